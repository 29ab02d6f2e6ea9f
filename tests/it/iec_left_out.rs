//! Connections of a drawing that generators of text leave out (Beremiz, OpenPLC), and edges that they detect once: such
//! drawings are refused.

use crate::iec_generated::refusal;
use common::iec::xml as iec_xml;

use iec_xml::{RAIL, at, bound, coil, contact, out, project, wired};

#[test]
fn an_edge_before_a_connector_that_is_used_several_times_is_refused() {
    let from_connector = |id: u32| at("continuation name=\"K\"", id, &[], "");
    let drawn = |edge: &str, uses: &[u32]| {
        let uses: String = uses.iter().map(|id| coil(*id, 4, &format!("x{id}"))).collect();
        let connector = at("connector name=\"K\"", 3, &[(2, "")], "");
        let body = format!(
            "<LD>{RAIL}{}{}{connector}{}{uses}</LD>",
            contact(1, edge, 0, "u"),
            contact(2, "", 1, "b"),
            from_connector(4)
        );
        project("", "u:BOOL b:BOOL x5:BOOL x6:BOOL", &body, "TRUE")
    };
    let edge = "edge=\"rising\"";
    let told = refusal(&drawn(edge, &[5, 6]));
    assert!(told.contains("generators detect the edge once"), "{told}");
    assert!(bound(&drawn(edge, &[5])).is_ok());
    assert!(bound(&drawn("", &[5, 6])).is_ok());
}

#[test]
fn a_continuation_of_an_unconnected_connector_is_refused() {
    let connector = at("connector name=\"k\"", 1, &[], "");
    let continued = at("continuation name=\"k\"", 2, &[], "");
    let body = format!("<FBD>{connector}{continued}{}</FBD>", out(3, (2, ""), "y"));
    let text = project("", "y:BOOL", &body, "TRUE");
    assert!(refusal(&text).contains("nothing is connected to its connector"));
    let unused = format!("<FBD>{connector}{continued}</FBD>");
    assert!(bound(&project("", "y:BOOL", &unused, "TRUE")).is_ok());
}

#[test]
fn connections_from_elements_without_an_output_are_refused() {
    for first in [out(2, (1, ""), "x"), at("rightPowerRail", 2, &[(1, "")], "")] {
        let body = format!("<FBD>{}{first}{}</FBD>", wired(1, "b"), out(3, (2, ""), "y"));
        let text = project("", "b:BOOL x:BOOL y:BOOL", &body, "TRUE");
        assert!(refusal(&text).contains("which has no output"), "{first}");
    }
}
