//! What instructions on blocks, digits, bytes and reals do, from the manuals; only where these settle it.

use super::{Device, Luck, Operand, Plc, extend};

/// The device so many places behind an operand's.
fn at(operand: &Operand, n: u32) -> Device {
    match *operand {
        Operand::Device((area, number), None) => (area, number + n),
        _ => panic!("no plain device: {operand:?}"),
    }
}

/// The decimal digits of a number as digits of four bits, the lowest first.
fn digits(mut value: i64) -> i64 {
    let (mut coded, mut place) = (0, 0);
    while value > 0 {
        coded |= (value % 10) << place;
        value /= 10;
        place += 4;
    }
    coded
}

/// The number that digits of four bits write down; none if one is above 9.
fn decimal(coded: i64) -> Option<i64> {
    format!("{coded:x}").parse().ok()
}

impl<L: Luck> Plc<'_, L> {
    /// Carries out an instruction of these; false if it is none.
    pub(super) fn data(&mut self, name: &str, operands: &[Operand]) -> bool {
        self.digits_and_products(name, operands)
            || self.blocks(name, operands)
            || self.bits_and_bytes(name, operands)
            || self.searches(name, operands)
            || self.reals(name, operands)
    }

    fn word(&mut self, operand: &Operand, n: u32) -> u16 {
        match operand {
            Operand::Constant(value) => *value as u16,
            _ => self.cell(at(operand, n)),
        }
    }

    fn double(&mut self, operand: &Operand, n: u32) -> u32 {
        u32::from(self.word(operand, 2 * n)) | u32::from(self.word(operand, 2 * n + 1)) << 16
    }

    fn put_all(&mut self, operand: &Operand, values: &[u16]) {
        for (n, value) in values.iter().enumerate() {
            self.put(at(operand, n as u32), *value);
        }
    }

    fn put_wide(&mut self, operand: &Operand, value: i64, words: u32) {
        let values: Vec<u16> = (0..words).map(|n| (value >> (16 * n)) as u16).collect();
        self.put_all(operand, &values);
    }

    fn digits_and_products(&mut self, name: &str, operands: &[Operand]) -> bool {
        let number = |plc: &mut Self, n: usize, words| plc.number(&operands[n], words);
        match name {
            "D*" => {
                let product = number(self, 0, 2) * number(self, 1, 2);
                self.put_wide(&operands[2], product, 4);
            }
            "D/" => {
                let (a, b) = (number(self, 0, 2), number(self, 1, 2));
                self.put_wide(&operands[2], a / b, 2);
                let rest = a % b;
                self.put(at(&operands[2], 2), rest as u16);
                self.put(at(&operands[2], 3), (rest >> 16) as u16);
            }
            "BCD" => {
                let value = number(self, 0, 1);
                self.set_number(&operands[1], 1, digits(value));
            }
            "DBCD" => {
                let value = number(self, 0, 2);
                self.set_number(&operands[1], 2, digits(value));
            }
            "BIN" => {
                let coded = number(self, 0, 1) & 0xFFFF;
                // An error leaves the destination as it is.
                if let Some(value) = decimal(coded) {
                    self.set_number(&operands[1], 1, value);
                }
            }
            "DBIN" => {
                let coded = number(self, 0, 2) & 0xFFFF_FFFF;
                if let Some(value) = decimal(coded) {
                    self.set_number(&operands[1], 2, value);
                }
            }
            "BKBCD" | "BKBIN" => {
                let count = number(self, 2, 1) as u32;
                let values: Option<Vec<u16>> = (0..count)
                    .map(|n| {
                        let value = i64::from(self.word(&operands[0], n));
                        let result =
                            if name == "BKBCD" { Some(digits(value)) } else { decimal(value) };
                        result.map(|value| value as u16)
                    })
                    .collect();
                if let Some(values) = values {
                    self.put_all(&operands[1], &values);
                }
            }
            "DBL" => {
                let value = number(self, 0, 1);
                self.set_number(&operands[1], 2, value);
            }
            "WORD" => {
                let value = number(self, 0, 2);
                self.set_number(&operands[1], 1, value);
            }
            "LIMIT" | "DLIMIT" => {
                let words = 1 + u32::from(name == "DLIMIT");
                let (low, high) = (number(self, 0, words), number(self, 1, words));
                let value = number(self, 2, words).max(low).min(high);
                self.set_number(&operands[3], words, value);
            }
            "BAND" | "DBAND" => {
                let words = 1 + u32::from(name == "DBAND");
                let (low, high) = (number(self, 0, words), number(self, 1, words));
                let value = number(self, 2, words);
                let inside = value.clamp(low, high);
                self.set_number(&operands[3], words, value - inside);
            }
            "ZONE" | "DZONE" => {
                let words = 1 + u32::from(name == "DZONE");
                let (low, high) = (number(self, 0, words), number(self, 1, words));
                let value = number(self, 2, words);
                let bias = [low, 0, high][(value.signum() + 1) as usize];
                self.set_number(&operands[3], words, value + bias);
            }
            "SECOND" => {
                let [h, m, s] = [0, 1, 2].map(|n| i64::from(self.word(&operands[0], n)));
                self.put_wide(&operands[1], (h * 60 + m) * 60 + s, 2);
            }
            "HOUR" => {
                let all = number(self, 0, 2);
                let parts = [all / 3600, all / 60 % 60, all % 60].map(|part| part as u16);
                self.put_all(&operands[1], &parts);
            }
            _ => return false,
        }
        true
    }

    fn blocks(&mut self, name: &str, operands: &[Operand]) -> bool {
        let count = match operands.last() {
            Some(Operand::Constant(count)) => *count as u32,
            Some(operand @ Operand::Device(_, None)) => u32::from(self.word(operand, 0)),
            _ => 0,
        };
        match name {
            "BK+" | "BK-" | "BKAND" | "BKOR" | "BKXOR" | "BKXNR" => {
                for n in 0..count {
                    let (a, b) = (self.word(&operands[0], n), self.word(&operands[1], n));
                    let value = match name {
                        "BK+" => a.wrapping_add(b),
                        "BK-" => a.wrapping_sub(b),
                        "BKAND" => a & b,
                        "BKOR" => a | b,
                        "BKXOR" => a ^ b,
                        _ => !(a ^ b),
                    };
                    self.put(at(&operands[2], n), value);
                }
            }
            name if name.starts_with("BKCMP") => {
                for n in 0..count {
                    let a = self.word(&operands[0], n) as i16;
                    let b = self.word(&operands[1], n) as i16;
                    let holds = match &name[5..] {
                        "=" => a == b,
                        "<>" => a != b,
                        "<" => a < b,
                        "<=" => a <= b,
                        ">" => a > b,
                        _ => a >= b,
                    };
                    self.put(at(&operands[2], n), holds.into());
                }
            }
            "DFMOV" => {
                let value = self.number(&operands[0], 2);
                for n in 0..count {
                    self.put(at(&operands[1], 2 * n), value as u16);
                    self.put(at(&operands[1], 2 * n + 1), (value >> 16) as u16);
                }
            }
            "BXCH" => {
                for n in 0..count {
                    let (a, b) = (self.word(&operands[0], n), self.word(&operands[1], n));
                    self.put(at(&operands[0], n), b);
                    self.put(at(&operands[1], n), a);
                }
            }
            "BKRST" => (0..count).for_each(|n| self.put(at(&operands[0], n), 0)),
            "DSFL" | "BSFL" => {
                for n in (1..count).rev() {
                    let below = self.word(&operands[0], n - 1);
                    self.put(at(&operands[0], n), below);
                }
                self.put(at(&operands[0], 0), 0);
            }
            "DSFR" | "BSFR" => {
                for n in 1..count {
                    let above = self.word(&operands[0], n);
                    self.put(at(&operands[0], n - 1), above);
                }
                self.put(at(&operands[0], count - 1), 0);
            }
            "DIS" => {
                let word = self.word(&operands[0], 0);
                let nibbles: Vec<u16> = (0..count).map(|n| word >> (4 * n) & 15).collect();
                self.put_all(&operands[1], &nibbles);
            }
            "UNI" => {
                let word =
                    (0..count).map(|n| (self.word(&operands[0], n) & 15) << (4 * n)).sum::<u16>();
                self.put(at(&operands[1], 0), word);
            }
            "WTOB" => {
                let bytes: Vec<u16> = (0..count)
                    .map(|n| self.word(&operands[0], n / 2) >> (8 * (n % 2)) & 0xFF)
                    .collect();
                self.put_all(&operands[1], &bytes);
            }
            "BTOW" => {
                let bytes: Vec<u16> =
                    (0..count).map(|n| self.word(&operands[0], n) & 0xFF).collect();
                let words: Vec<u16> = bytes
                    .chunks(2)
                    .map(|two| two[0] + 256 * two.get(1).copied().unwrap_or(0))
                    .collect();
                self.put_all(&operands[1], &words);
            }
            "FIFW" => {
                let stored = self.word(&operands[1], 0);
                let value = self.word(&operands[0], 0);
                self.put(at(&operands[1], u32::from(stored) + 1), value);
                self.put(at(&operands[1], 0), stored + 1);
            }
            _ => return false,
        }
        true
    }

    fn bits_and_bytes(&mut self, name: &str, operands: &[Operand]) -> bool {
        match name {
            "SWAP" => {
                let value = self.word(&operands[0], 0);
                self.put(at(&operands[0], 0), (value & 0xFF) * 256 + value / 256);
            }
            "SUM" => {
                let value = self.number(&operands[0], 1) & 0xFFFF;
                let ones = (0..16).filter(|bit| value >> bit & 1 == 1).count();
                self.set_number(&operands[1], 1, ones as i64);
            }
            "ROL" | "ROR" => {
                let places = self.number(&operands[1], 1);
                for _ in 0..places {
                    let value = self.word(&operands[0], 0);
                    let turned = if name == "ROL" {
                        value.rotate_left(1)
                    } else {
                        value >> 1 | (value & 1) << 15
                    };
                    self.put(at(&operands[0], 0), turned);
                }
            }
            "DROL" | "DROR" => {
                let places = self.number(&operands[1], 1);
                let mut value = self.double(&operands[0], 0);
                for _ in 0..places {
                    value = if name == "DROL" {
                        value.rotate_left(1)
                    } else {
                        value >> 1 | (value & 1) << 31
                    };
                }
                self.put_wide(&operands[0], i64::from(value), 2);
            }
            "SFL" | "SFR" => {
                let places = self.number(&operands[1], 1);
                for _ in 0..places {
                    let value = self.word(&operands[0], 0);
                    let moved = if name == "SFL" { value << 1 } else { value >> 1 };
                    self.put(at(&operands[0], 0), moved);
                }
            }
            "TEST" | "DTEST" => {
                let words = 1 + i64::from(name == "DTEST");
                let value = self.number(&operands[0], words as u32);
                let bit = self.number(&operands[1], 1) & (16 * words - 1);
                self.set_bit(&operands[2], value >> bit & 1 == 1);
            }
            "DECO" => {
                let Operand::Constant(power) = operands[2] else { panic!("DECO") };
                let which = self.number(&operands[0], 1) & ((1 << power) - 1);
                for n in 0..1 << power {
                    self.put(at(&operands[1], n), u16::from(i64::from(n) == which));
                }
            }
            "ENCO" => {
                let Operand::Constant(power) = operands[2] else { panic!("ENCO") };
                let highest =
                    (0..1 << power).rev().find(|&n| self.cell(at(&operands[0], n)) & 1 == 1);
                self.set_number(&operands[1], 1, i64::from(highest.expect("a bit is on")));
            }
            _ => return false,
        }
        true
    }

    fn searches(&mut self, name: &str, operands: &[Operand]) -> bool {
        let Some(&Operand::Constant(count)) = operands.last() else { return false };
        let count = count as u32;
        let values = |plc: &mut Self, n: usize| -> Vec<i64> {
            (0..count).map(|k| extend(i64::from(plc.word(&operands[n], k)), 1)).collect()
        };
        let doubles = |plc: &mut Self, n: usize| -> Vec<i64> {
            (0..count).map(|k| extend(i64::from(plc.double(&operands[n], k)), 2)).collect()
        };
        match name {
            "SER" => {
                let wanted = self.number(&operands[0], 1);
                let all = values(self, 1);
                let first = all.iter().position(|value| *value == wanted).map_or(0, |n| n + 1);
                let found = all.iter().filter(|value| **value == wanted).count();
                self.put_all(&operands[2], &[first as u16, found as u16]);
            }
            "DSER" => {
                let wanted = self.number(&operands[0], 2);
                let all = doubles(self, 1);
                let first = all.iter().position(|value| *value == wanted).map_or(0, |n| n + 1);
                let found = all.iter().filter(|value| **value == wanted).count();
                self.put_all(&operands[2], &[first as u16, found as u16]);
            }
            "MAX" | "MIN" | "DMAX" | "DMIN" => {
                let wide = name.starts_with('D');
                let all = if wide { doubles(self, 0) } else { values(self, 0) };
                let best = if name.ends_with("MAX") { all.iter().max() } else { all.iter().min() };
                let best = *best.expect("some");
                let first = all.iter().position(|value| *value == best).expect("it is there") + 1;
                let found = all.iter().filter(|value| **value == best).count();
                let mut result = vec![best as u16];
                if wide {
                    result.push((best >> 16) as u16);
                }
                result.extend([first as u16, found as u16]);
                self.put_all(&operands[1], &result);
            }
            "WSUM" => {
                let sum: i64 = values(self, 0).iter().sum();
                self.put_wide(&operands[1], sum, 2);
            }
            "DWSUM" => {
                let sum: i64 = doubles(self, 0).iter().sum();
                self.put_wide(&operands[1], sum, 4);
            }
            "MEAN" => {
                let sum: i64 = values(self, 0).iter().sum();
                self.put_wide(&operands[1], sum / i64::from(count), 1);
            }
            _ => return false,
        }
        true
    }

    fn reals(&mut self, name: &str, operands: &[Operand]) -> bool {
        let real = |plc: &mut Self, n: usize| f32::from_bits(plc.double(&operands[n], 0));
        let last = operands.last().expect("operands");
        match name {
            "FLT" => {
                let value = self.number(&operands[0], 1) as f32;
                self.put_wide(last, i64::from(value.to_bits()), 2);
            }
            "DFLT" => {
                let value = self.number(&operands[0], 2) as f32;
                self.put_wide(last, i64::from(value.to_bits()), 2);
            }
            "INT" => {
                let value = real(self, 0) as i64;
                self.put_wide(last, value, 1);
            }
            "DINT" => {
                let value = real(self, 0) as i64;
                self.put_wide(last, value, 2);
            }
            "E+" | "E-" | "E*" | "E/" => {
                // With two operands the destination is the left side.
                let (left, right) = if operands.len() == 2 { (1, 0) } else { (0, 1) };
                let (a, b) = (real(self, left), real(self, right));
                let value = match name {
                    "E+" => a + b,
                    "E-" => a - b,
                    "E*" => a * b,
                    _ => a / b,
                };
                self.put_wide(last, i64::from(value.to_bits()), 2);
            }
            _ => return false,
        }
        true
    }
}
