//! The control of an action as IEC 61131-3 draws it: the standard's own flip-flops, timers and edges, one at each
//! input.

use super::machine::Machine;

/// All qualifiers, by their names.
pub const QUALIFIERS: &[&str] = &["N", "R", "S", "L", "D", "P", "P0", "P1", "SD", "DS", "SL"];

/// Whether a qualifier has a time.
pub fn is_timed(qualifier: &str) -> bool {
    matches!(qualifier, "L" | "D" | "SD" | "DS" | "SL")
}

/// One scan of the control under this name, with a time in milliseconds: whether the action's body is carried out.
/// `active` says of a qualifier whether a step that has the action with it is active.
pub fn runs(
    machine: &mut Machine<'_>,
    name: &str,
    time: i64,
    active: &dyn Fn(&str) -> bool,
) -> bool {
    let mut block = |kind: &str, own: &str, inputs: &[(&str, bool)], output: &str| {
        let at = format!("{name}{own}.");
        machine.state.insert(format!("{at}PT"), time);
        for (input, value) in inputs {
            machine.state.insert(format!("{at}{input}"), i64::from(*value));
        }
        machine.standard(kind, &at);
        machine.get(&format!("{at}{output}")) == 1
    };
    let reset = active("R");
    let stored = block("RS", "S_FF", &[("S", active("S")), ("R1", reset)], "Q1");
    let limit = block("TON", "L_TMR", &[("IN", active("L"))], "Q");
    let delayed = block("TON", "D_TMR", &[("IN", active("D"))], "Q");
    let pulse = block("R_TRIG", "P_TRIG", &[("CLK", active("P"))], "Q");
    let sd = block("RS", "SD_FF", &[("S", active("SD")), ("R1", reset)], "Q1");
    let sd = block("TON", "SD_TMR", &[("IN", sd)], "Q");
    let ds = block("TON", "DS_TMR", &[("IN", active("DS"))], "Q");
    let ds = block("RS", "DS_FF", &[("S", ds), ("R1", reset)], "Q1");
    let sl = block("RS", "SL_FF", &[("S", active("SL")), ("R1", reset)], "Q1");
    let sl_over = block("TON", "SL_TMR", &[("IN", sl)], "Q");
    let any = active("N")
        || stored
        || (active("L") && !limit)
        || delayed
        || pulse
        || sd
        || ds
        || (sl && !sl_over);
    let on = any && !reset;
    // The final scan.
    let last = block("F_TRIG", "Q_TRIG", &[("CLK", on)], "Q");
    let first = block("R_TRIG", "P1_TRIG", &[("CLK", active("P1"))], "Q");
    let ended = block("F_TRIG", "P0_TRIG", &[("CLK", active("P0"))], "Q");
    on || last || first || ended
}
