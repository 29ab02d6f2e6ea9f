//! The worst response time.

use schemars::JsonSchema;
use serde::Serialize;

#[derive(Serialize, JsonSchema)]
pub(super) struct Response<'a> {
    input_ps: u64,
    input_evidence: &'static str,
    input_why: &'a str,
    scans: u64,
    scan_ps: u64,
    output_ps: u64,
    output_evidence: &'static str,
    output_why: &'a str,
    upper_ps: u64,
}

pub(super) fn response(response: &scanbound_audit::response::Response) -> Response<'_> {
    Response {
        input_ps: response.input.time.0,
        input_evidence: response.input.evidence.word(),
        input_why: &response.input.source,
        scans: response.scans,
        scan_ps: response.scan.0,
        output_ps: response.output.time.0,
        output_evidence: response.output.evidence.word(),
        output_why: &response.output.source,
        upper_ps: response.total.0,
    }
}
