//! The MINASEC-U's words as the analysis understands them, held against the emulated machine.

use proptest::prelude::*;
use scanbound::base::time::{Picos, Times};
use scanbound::front::minasec::decode::decode;
use scanbound::front::minasec::{BINARY, Device, DeviceKind, Opcode, Source, WORDS, Word};
use scanbound::minasec::stimulus::{Change, Stimulus, What};
use scanbound::minasec::{Machine, Settings, View};
use scanbound::program::{AreaKind, Cell, ChoiceKey, Program};
use scanbound::replay::{FreeValues, replay_with};

/// Gives the interpreter the devices as the machine has them when the scan begins.
struct Begun<'a> {
    program: &'a Program,
    view: View,
}

impl FreeValues for &Begun<'_> {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        let device = Device::from_name(&self.program.cell_name(cell)).expect("a device");
        u16::from(self.view.device(device))
    }

    fn choice(&mut self, _key: &ChoiceKey, _kind: AreaKind) -> u16 {
        unreachable!("neither timers nor the counter are read")
    }
}

/// A word that reads and writes latches only, and the clear, which reads as 0.
fn word() -> impl Strategy<Value = Word> {
    (0..8_usize, prop_oneof![0..28_u8, Just(31)]).prop_map(|(opcode, device)| {
        let opcode = Opcode::ALL[opcode];
        let device = Device::at(device);
        let latch = matches!(device.kind(), DeviceKind::Output | DeviceKind::Relay);
        // What can't be written is read.
        let opcode = if opcode.is_store() && !latch { Opcode::Or } else { opcode };
        Word::new(opcode, device)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn the_interpreter_stores_what_the_machine_stores(
        words in prop::collection::vec(word(), WORDS),
        inputs in prop::collection::vec(any::<u8>(), 1..6),
    ) {
        let mut source = Source::new("random.bin", BINARY);
        source.words.copy_from_slice(&words);
        source.words[0] = Word::new(Opcode::Ldi, Device::at(words[0].0));
        let program = decode(&source);
        prop_assert_eq!(program.instructions.len(), WORDS);
        let scan = 8_448_000_000;
        let changes = inputs.iter().enumerate().flat_map(|(turn, bits)| {
            (0..8).map(move |bit| Change {
                at: Picos(turn as u64 * scan),
                what: What::Input(bit),
                on: bits >> bit & 1 == 1,
            })
        });
        let settings = Settings { filter: Picos::ZERO, ..Settings::default() };
        let mut machine =
            Machine::new(source.words, &settings, &Stimulus { changes: changes.collect() });
        let times = vec![Times::new(Picos(33_000_000), Picos(33_000_000)); WORDS];
        for bits in &inputs {
            let before = machine.view();
            let after = machine.scan(&mut ()).expect("a scan");
            prop_assert_eq!(after.view.inputs(), *bits);
            let mut view = before;
            view.devices = view.devices & !0xFF | u32::from(*bits);
            let replayed = replay_with(&program, &times, &Begun { program: &program, view });
            // A store fires with the value that it stores.
            let mut devices = view.devices;
            for event in &replayed.events {
                let word = source.words[event.instruction];
                if word.opcode().is_store() {
                    let bit = 1 << word.device().address();
                    devices = devices & !bit | if event.fired { bit } else { 0 };
                }
            }
            let latches = 0x0FFF_FFFF;
            prop_assert_eq!(devices & latches, after.view.devices & latches);
            prop_assert_eq!(replayed.total, after.time);
        }
    }
}
