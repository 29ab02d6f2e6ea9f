//! The control of one action, as the standard's block ACTION_CONTROL has it.
//!
//! All blocks of a chart that name the action feed one control. R dominates: while a step with R is active the action
//! is off and nothing is stored. Steps whose blocks have the same qualifier and the same time come in together, so that
//! no edge is seen where one follows the other. The standard's block has one time for all; here each time has a timer
//! of its own, which is the same wherever an action has one time.

use scanbound::iec::chart::Qualifier;

/// What comes in at one input of the control in one scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Input {
    /// Its qualifier.
    pub qualifier: Qualifier,
    /// Its time in nanoseconds; 0 without one.
    pub time: i64,
    /// Whether one of its steps is active.
    pub active: bool,
}

/// What comes of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Output {
    /// The state of the action: what a Boolean variable takes.
    pub q: bool,
    /// Whether the action's body is carried out.
    pub runs: bool,
}

/// What is remembered of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
struct Memory {
    /// Whether its step was active in the scan before.
    was: bool,
    /// Whether it is stored, for SD, DS and SL.
    stored: bool,
    /// Since when its timer runs.
    since: Option<i64>,
}

impl Memory {
    /// An on-delay timer: whether its time is over.
    fn timer(&mut self, input: bool, time: i64, now: i64) -> bool {
        if !input {
            self.since = None;
            return false;
        }
        now - *self.since.get_or_insert(now) >= time
    }
}

/// The control of one action.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Control {
    stored: bool,
    blocks: Vec<Memory>,
    before: bool,
}

impl Control {
    /// Takes this moment for the beginning of time; what is longer ago than the horizon is taken to be just so long
    /// ago.
    pub fn begin_time_at(&mut self, now: i64, horizon: i64) {
        for own in &mut self.blocks {
            own.since = own.since.map(|since| (since - now).max(-horizon));
        }
    }

    /// The next scan, at this time in nanoseconds. The inputs are the same ones in every scan, in the same order.
    pub fn scan(&mut self, inputs: &[Input], now: i64, final_scan: bool) -> Output {
        self.blocks.resize(inputs.len(), Memory::default());
        let any = |kind: Qualifier| inputs.iter().any(|one| one.qualifier == kind && one.active);
        let reset = any(Qualifier::R);
        self.stored = (self.stored || any(Qualifier::S)) && !reset;
        let (mut q, mut pulse) = (any(Qualifier::N) || self.stored, false);
        for (&Input { qualifier, time, active }, own) in inputs.iter().zip(&mut self.blocks) {
            let (rises, falls) = (active && !own.was, !active && own.was);
            own.was = active;
            match qualifier {
                Qualifier::N | Qualifier::R | Qualifier::S => {}
                Qualifier::L => {
                    let over = own.timer(active, time, now);
                    q |= active && !over;
                }
                Qualifier::D => q |= own.timer(active, time, now),
                Qualifier::P => q |= rises,
                Qualifier::P1 => pulse |= rises,
                Qualifier::P0 => pulse |= falls,
                Qualifier::Sd => {
                    own.stored = (own.stored || active) && !reset;
                    q |= own.timer(own.stored, time, now);
                }
                Qualifier::Ds => {
                    let due = own.timer(active, time, now);
                    own.stored = (own.stored || due) && !reset;
                    q |= own.stored;
                }
                Qualifier::Sl => {
                    own.stored = (own.stored || active) && !reset;
                    let over = own.timer(own.stored, time, now);
                    q |= own.stored && !over;
                }
            }
        }
        q &= !reset;
        let last = final_scan && self.before && !q;
        self.before = q;
        Output { q: q || pulse, runs: q || pulse || last }
    }
}
