//! From a priced program to the model of one scan, within limits on its size.

use super::Failure;
use scanbound_base::budget::Budget;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{Program, SummaryReason};
use scanbound_model::ScanModel;
use scanbound_passes::loops;
use scanbound_scan::size_limits::{SizeLimits, scan_model_fitted};
use scanbound_scan::{Purpose, ScanError, scan_model, scan_model_with_knowledge};
use scanbound_timing::price::Prices;
use scanbound_timing::table::Table;
use std::collections::BTreeMap;

/// The largest number of instructions by which following loops and calls may raise the number of executed instructions.
const MAX_UNROLLED: u64 = 200_000;
/// The largest number of rounds in which loops are followed because the model shows their number of iterations.
const MAX_NESTING: usize = 8;
/// A model may have this many nodes and questions about words, in addition to [`NODES_EACH`] for each executed
/// instruction.
const NODES: usize = 1_000_000;
/// A model may have this many nodes and questions about words for each executed instruction, in addition to [`NODES`].
const NODES_EACH: usize = 48;
/// No model may have more nodes and questions about words than this.
const MAX_NODES: usize = 8_000_000;
/// The longest scan time that is accepted: a thousand hours.
pub const LONGEST_SCAN: Picos = Picos(3_600_000_000_000_000_000);

/// Refuses a scan whose times add up to more than [`LONGEST_SCAN`], so that sums of times cannot overflow. No PLC has
/// such a scan.
pub fn keep_in_range(
    program: &Program,
    table: &Table,
    prices: &Prices,
    model: &ScanModel,
) -> Result<(), Failure> {
    let terms = prices.overhead.iter().map(|term| term.time);
    let points = prices.points.iter().filter_map(|points| points.most.as_ref());
    let others = terms.chain(points.map(|most| most.more)).map(|time| u128::from(time.0));
    let sum = model.sum_of_largest() + others.sum::<u128>();
    if sum <= u128::from(LONGEST_SCAN.0) {
        return Ok(());
    }
    let message = format!("the times of one scan add up to more than {LONGEST_SCAN}");
    let help = "check the times in the table and how often loops run";
    let most = model.charges.iter().max_by_key(|charge| charge.largest_cost());
    let most = most.filter(|charge| u128::from(charge.largest_cost().0) * 2 > sum);
    let Some(charge) = most else {
        return Err(Failure::from(Diagnostic::file(Code::NoTime, &table.name, message, help)));
    };
    // One instruction takes more than half of the time: the fault is reported there.
    let at = &program.instructions[charge.instruction];
    let message = format!(
        "{message}; the times of this instruction alone add up to {}",
        charge.largest_cost().best_text()
    );
    Err(Failure::from(program.fault(at, Code::NoTime, message, help)))
}

/// The model of a scan, and whether it is only the structural bound. It is the structural bound if the time is over or
/// the model would be too large.
///
/// Before, [`fit`] summarised what runs too often; `executed` is the number of instructions that remain. If the model
/// shows that a summarised loop makes fewer iterations than it was charged, the loop is followed after all.
pub fn model_of(
    program: &mut Program,
    prices: &mut Prices,
    executed: u64,
    budget: &Budget<'_>,
) -> Result<(ScanModel, bool), Failure> {
    let why = match follow(program, prices, executed, budget)? {
        Ok(mut model) => {
            // Following one loop may show the count of another, inside or after it.
            for _ in 0..MAX_NESTING {
                let Some(mut closer) = loops::restore(program, &model.iterations) else { break };
                let Ok(executed) = fit(&mut closer) else { break };
                let mut priced = prices.clone();
                let found = follow(&mut closer, &mut priced, executed, budget);
                let Ok(Ok(found)) = found else { break };
                (model, *program, *prices) = (found, closer, priced);
            }
            return Ok((model, false));
        }
        Err(why) => why,
    };
    if why == SummaryReason::TimeLimit {
        budget.record_stop(
            "following the scan",
            "the bound is the sum of all instructions that can run, each at its larger time",
        );
    }
    let summed = loops::summarise_all(program, why);
    summed.map_err(|error| cannot_follow(program, &too_often(error)))?;
    prices.instructions.resize(program.instructions.len(), None);
    let model = scan_model(program, &prices.times());
    Ok((model.map_err(|error| cannot_follow(program, &error))?, true))
}

/// The program, its prices and its model after loops were put back: each summarised loop of which `iterations` says
/// that it makes fewer iterations than it was charged is followed. `None` if there are no such loops, or if following
/// them exceeds the limits.
pub fn put_back(
    program: &Program,
    prices: &Prices,
    knowledge: &Knowledge,
    iterations: &BTreeMap<usize, u32>,
    limits: &SizeLimits<'_>,
) -> Option<(Program, Prices, ScanModel)> {
    let mut closer = loops::restore(program, iterations)?;
    loops::fit(&mut closer, MAX_UNROLLED).ok()?;
    let mut priced = prices.clone();
    priced.instructions.resize(closer.instructions.len(), None);
    let times = priced.times();
    let model =
        scan_model_with_knowledge(&closer, &times, knowledge, Purpose::UpperBound, limits).ok()?;
    Some((closer, priced, model))
}

/// Gives up following loops and routines that execute too many instructions. Returns the largest number of instructions
/// that a scan then executes.
pub fn fit(program: &mut Program) -> Result<u64, Failure> {
    let fitted = loops::fit(program, MAX_UNROLLED).map_err(too_often);
    fitted.map_err(|error| cannot_follow(program, &error))
}

/// Makes the model of a scan that executes this many instructions. The inner `Err` says why that is not possible: the
/// time is over, or the model would be too large.
fn follow(
    program: &mut Program,
    prices: &mut Prices,
    executed: u64,
    budget: &Budget<'_>,
) -> Result<Result<ScanModel, SummaryReason>, Failure> {
    // Instructions that the summaries added have no price.
    prices.instructions.resize(program.instructions.len(), None);
    let executed = usize::try_from(executed).unwrap_or(usize::MAX);
    let most = executed.saturating_mul(NODES_EACH).saturating_add(NODES).min(MAX_NODES);
    match scan_model_fitted(program, &prices.times(), most, &|| budget.must_stop()) {
        Ok(Some(model)) => Ok(Ok(model)),
        Ok(None) => Ok(Err(SummaryReason::ValuesTooComplex)),
        Err(ScanError::Stopped { .. }) => Ok(Err(SummaryReason::TimeLimit)),
        Err(error) => Err(cannot_follow(program, &error)),
    }
}

fn too_often(loops::CountOverflow { instruction }: loops::CountOverflow) -> ScanError {
    ScanError::CostOverflow { instruction }
}

fn cannot_follow(program: &Program, error: &ScanError) -> Failure {
    let (ScanError::TooManyExecutions { instruction, .. }
    | ScanError::CostOverflow { instruction }
    | ScanError::TooLarge { instruction, .. }
    | ScanError::Stopped { instruction }
    | ScanError::NoResult { instruction }) = error;
    let at = &program.instructions[*instruction];
    let help = match error {
        ScanError::TooManyExecutions { .. }
        | ScanError::CostOverflow { .. }
        | ScanError::TooLarge { .. }
        | ScanError::Stopped { .. } => {
            "state a smaller range for the word that holds the loop's number of iterations, or split the program"
        }
        ScanError::NoResult { .. } => {
            "begin each rung with LD, and let no jump lead into the middle of a rung"
        }
    };
    Failure::from(program.fault(at, Code::Scan, error.to_string(), help))
}
