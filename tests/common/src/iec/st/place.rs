//! Memory: where variables lie, and what they hold.

use super::tree::{ADDRESSES, COLOURS, Project, Section, Ty, Variable};
use std::collections::BTreeMap;

#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A whole number, a truth value, a duration in milliseconds or the value of an enumeration.
    Int(i128),
    Real(f32),
    Text(String),
    /// What a pointer, a reference, an interface or a parameter means.
    Meant(Option<Loc>),
}

impl Value {
    pub fn int(&self) -> i128 {
        match self {
            Value::Int(value) => *value,
            other => panic!("{other:?} is no whole number"),
        }
    }

    pub fn real(&self) -> f32 {
        match self {
            Value::Real(value) => *value,
            other => panic!("{other:?} is no real number"),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum At {
    Cell(usize),
    /// From this bit on among those that have direct addresses.
    Bit(u64),
}

/// A variable, or a part of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Loc {
    pub at: At,
    pub ty: Ty,
    /// One bit of it alone.
    pub bit: Option<u32>,
}

/// How controllers count addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counting {
    /// `%MW4` begins with the fourth byte.
    Bytes,
    /// `%MW4` begins with the eighth byte.
    Units,
    /// What has different addresses has no memory in common.
    Apart,
}

/// The first bit of an address.
pub fn first_bit(address: &str, counting: Counting) -> u64 {
    let rest = &address[2..];
    let digits = rest.trim_start_matches(|c: char| c.is_ascii_alphabetic());
    let size = match &rest[..rest.len() - digits.len()] {
        "X" => 1,
        "B" => 8,
        "W" => 16,
        _ => 32,
    };
    let numbers: Vec<u64> = digits.split('.').map(|one| one.parse().expect("a number")).collect();
    let area = if address.starts_with("%I") { 1 << 40 } else { 0 };
    let at = match (counting, size) {
        (Counting::Apart, _) => {
            let own = address.bytes().fold(0_u64, |sum, byte| sum * 131 + u64::from(byte));
            return own % (1 << 30) * 64;
        }
        (_, 1) => numbers[0] * 8 + numbers[1],
        (Counting::Bytes, _) => numbers[0] * 8,
        (Counting::Units, _) => numbers[0] * size,
    };
    area + at
}

/// Where the variables of a block's instances lie.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    pub size: usize,
    /// By the number of a variable: its first cell within an instance.
    pub members: Vec<usize>,
    /// Variables of methods that each instance keeps: method, variable, first cell.
    pub kept: BTreeMap<(usize, usize), usize>,
}

pub fn pins(kind: &str) -> &'static [(&'static str, Ty)] {
    const B: Ty = Ty::Bool;
    const T: Ty = Ty::Time;
    const N: Ty = Ty::Number(super::tree::NUMBERS[1]);
    match kind {
        "R_TRIG" | "F_TRIG" => &[("CLK", B), ("Q", B), ("m", B)],
        "SR" => &[("S1", B), ("R", B), ("Q1", B)],
        "RS" => &[("S", B), ("R1", B), ("Q1", B)],
        "CTU" => &[("CU", B), ("R", B), ("PV", N), ("Q", B), ("CV", N), ("m", B)],
        "CTD" => &[("CD", B), ("LD", B), ("PV", N), ("Q", B), ("CV", N), ("m", B)],
        "CTUD" => &[
            ("CU", B),
            ("CD", B),
            ("R", B),
            ("LD", B),
            ("PV", N),
            ("QU", B),
            ("QD", B),
            ("CV", N),
            ("m", B),
            ("n", B),
        ],
        _ => &[("IN", B), ("PT", T), ("Q", B), ("ET", T), ("m", B)],
    }
}

pub fn pin(kind: &str, name: &str) -> usize {
    pins(kind).iter().position(|one| one.0 == name).expect("a pin")
}

/// Where all variables lie.
pub struct Map {
    pub layouts: Vec<Layout>,
}

impl Map {
    pub fn new(project: &Project) -> Map {
        let mut map = Map { layouts: Vec::new() };
        for block in &project.blocks {
            let mut own = Layout {
                size: block.base.map_or(0, |base| map.layouts[base].size),
                ..Layout::default()
            };
            for variable in &block.variables {
                own.members.push(own.size);
                own.size += map.taken(project, variable);
            }
            for (number, method) in block.methods.iter().enumerate() {
                for (at, variable) in method.variables.iter().enumerate() {
                    if variable.section == Section::Instance {
                        own.kept.insert((number, at), own.size);
                        own.size += map.size(project, &variable.ty);
                    }
                }
            }
            map.layouts.push(own);
        }
        map
    }

    /// How many cells a variable takes where it lies.
    pub fn taken(&self, project: &Project, variable: &Variable) -> usize {
        match variable.section {
            Section::InOut => 1,
            _ => self.size(project, &variable.ty),
        }
    }

    pub fn size(&self, project: &Project, ty: &Ty) -> usize {
        match ty {
            Ty::Array(dimensions, of) => {
                let many: i128 = dimensions.iter().map(|(low, high)| high - low + 1).product();
                usize::try_from(many).expect("small") * self.size(project, of)
            }
            Ty::Struct(of) => {
                project.parts(*of).iter().map(|one| self.size(project, &one.ty)).sum()
            }
            Ty::Block(of) => self.layouts[*of].size,
            Ty::Standard(kind) => pins(kind).len(),
            _ => 1,
        }
    }
}

/// What a variable holds where nothing is declared.
pub fn plain(ty: &Ty) -> Value {
    match ty {
        Ty::Real => Value::Real(0.0),
        Ty::Text => Value::Text(String::new()),
        Ty::Colour => Value::Int(COLOURS[0].1),
        Ty::Interface | Ty::Pointer(_) | Ty::Reference(_) => Value::Meant(None),
        _ => Value::Int(0),
    }
}

/// A value as one of a type.
pub fn kept(ty: &Ty, value: Value) -> Value {
    match (ty, value) {
        (Ty::Number(of), Value::Int(value)) => Value::Int(of.keep(value)),
        (Ty::Time, Value::Int(value)) => Value::Int(super::tree::NUMBERS[2].keep(value)),
        #[allow(clippy::cast_precision_loss)]
        (Ty::Real, Value::Int(value)) => Value::Real(value as f32),
        (_, value) => value,
    }
}

/// How many bits a type has at a direct address.
pub fn width(ty: &Ty) -> u32 {
    match ty {
        Ty::Bool => 1,
        Ty::Number(of) => of.bits,
        other => panic!("{other:?} at an address"),
    }
}

/// The variable that a direct address means by itself.
pub fn address(number: usize, counting: Counting) -> Loc {
    let (at, of) = ADDRESSES[number];
    let ty = if of == "BOOL" { Ty::Bool } else { Ty::named(of) };
    Loc { at: At::Bit(first_bit(at, counting)), ty, bit: None }
}
