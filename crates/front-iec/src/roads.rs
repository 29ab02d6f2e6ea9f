//! Which lowering a project takes while there are two: that by the typed tree, or, for what the tree does not have, that by names.
//! Only builds for tests look at the environment: `SCANBOUND_IEC_ROAD=names` takes the old one, and `both` lowers with both,
//! compares the programs and appends the outcome to the file that `SCANBOUND_IEC_LOG` names.

use super::{decode as names, lower};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_iec::Project;
use scanbound_iec_tree::resolve::NOT_YET;
use scanbound_ir::{AreaId, Cell, Program, Region};
use std::collections::BTreeMap;
use std::io::Write as _;

/// What a project means.
pub(super) fn decode(
    project: &Project,
    dialect: &str,
    charts: names::Options,
    asked: &scanbound_front::Options<'_>,
) -> Result<Program, Vec<Diagnostic>> {
    let road = match cfg!(debug_assertions) {
        true => std::env::var("SCANBOUND_IEC_ROAD").unwrap_or_default(),
        false => String::new(),
    };
    if road == "names" {
        return names::decode(project, dialect, charts, asked);
    }
    let tree = lower::decode(project, dialect, charts, asked);
    if road.is_empty() {
        return match &tree {
            Err(faults) if is_not_yet(faults) => names::decode(project, dialect, charts, asked),
            _ => tree,
        };
    }
    let found = names::decode(project, dialect, charts, asked);
    log(&outcome(&found, &tree), project);
    found
}

fn is_not_yet(faults: &[Diagnostic]) -> bool {
    faults.iter().any(|one| one.message.contains(NOT_YET))
}

fn log(outcome: &str, project: &Project) {
    let Ok(path) = std::env::var("SCANBOUND_IEC_LOG") else { return };
    let first = project.files.first().map_or("", String::as_str);
    let unit = project.pous.first().map_or("", |pou| &pou.name);
    let thread = std::thread::current();
    let name = thread.name().unwrap_or_default();
    let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
    if let Ok(mut file) = file {
        _ = writeln!(file, "{outcome}\t{name}\t{first}\t{unit}");
    }
}

type Lowered = Result<Program, Vec<Diagnostic>>;

/// How the programs of both roads compare.
fn outcome(names: &Lowered, tree: &Lowered) -> String {
    let first =
        |faults: &[Diagnostic]| faults.first().map_or(String::new(), |one| one.message.clone());
    match (names, tree) {
        (_, Err(faults)) if is_not_yet(faults) => {
            let mut of = faults.iter().filter(|one| one.message.contains(NOT_YET));
            let of = of.next().map_or("", |one| one.message.as_str());
            let what = of.split_once(NOT_YET).map_or("", |(_, what)| what);
            format!("not yet{what}")
        }
        (Err(one), Err(two)) if first(one) == first(two) => "same fault".to_owned(),
        (Err(one), Err(two)) => format!("other fault: {} / {}", first(one), first(two)),
        (Ok(_), Err(faults)) => format!("refused: {}", first(faults)),
        (Err(faults), Ok(_)) => format!("accepted: {}", first(faults)),
        (Ok(one), Ok(two)) => {
            let (one, two) = (Shown::of(one), Shown::of(two));
            let mut pairs = one.lines.iter().zip(&two.lines);
            match pairs.position(|(one, two)| one != two) {
                Some(at) => format!("differs at {at}: {} / {}", one.lines[at], two.lines[at]),
                None if one.lines.len() != two.lines.len() => {
                    format!("differs in length: {} / {}", one.lines.len(), two.lines.len())
                }
                None => "same".to_owned(),
            }
        }
    }
}

/// A program as lines in which nothing depends on where variables lie and how values between are numbered.
struct Shown<'p> {
    program: &'p Program,
    lines: Vec<String>,
    between: BTreeMap<Cell, usize>,
    choices: BTreeMap<u32, usize>,
    /// Choices whose meanings are to be shown.
    open: Vec<u32>,
}

impl<'p> Shown<'p> {
    fn of(program: &'p Program) -> Shown<'p> {
        let mut shown = Shown {
            program,
            lines: Vec::new(),
            between: BTreeMap::new(),
            choices: BTreeMap::new(),
            open: Vec::new(),
        };
        for (at, one) in program.instructions.iter().enumerate() {
            let error = program.errors.get(&at);
            let text = format!(
                "{}:{} {} {:?} {:?} {:?} {error:?}",
                one.place.file, one.place.line, one.text, one.timing, one.effects, one.step
            );
            shown.push(&text);
        }
        let start = &program.power_up;
        for (what, regions) in
            [("inputs", &start.inputs), ("latched", &start.latched), ("cleared", &start.cleared)]
        {
            let mut cells: Vec<String> = Vec::new();
            for region in regions {
                if let Region::Range { first, count } = region {
                    cells.extend(
                        (0..(*count).min(20_000)).map(|at| program.cell_name(first.plus(at))),
                    );
                }
            }
            cells.sort();
            cells.dedup();
            shown.lines.push(format!("{what}: {}", cells.join(" ")));
        }
        let mut values: Vec<String> = { &start.values }
            .iter()
            .map(|(cell, word)| format!("{} = {word}", program.cell_name(*cell)))
            .collect();
        values.sort();
        shown.lines.push(format!("values: {}", values.join(" ")));
        let mut told: Vec<String> = program
            .approximations
            .iter()
            .map(|one| format!("{}: {:?}", one.instruction, one))
            .collect();
        told.sort();
        shown.lines.push(format!("approximated: {}", told.join("; ")));
        shown
    }

    /// Takes in a text in which cells and choices stand as they are shown for developers.
    fn push(&mut self, text: &str) {
        let mut found = String::new();
        let mut rest = text;
        while let Some(at) =
            rest.find("Cell { area: AreaId(").into_iter().chain(rest.find("ChoiceId(")).min()
        {
            found += &rest[..at];
            rest = &rest[at..];
            if let Some(behind) = rest.strip_prefix("ChoiceId(") {
                let end = behind.find(')').unwrap_or(0);
                let number: u32 = behind[..end].parse().unwrap_or(0);
                let next = self.choices.len();
                let known = *self.choices.entry(number).or_insert_with(|| {
                    self.open.push(number);
                    next
                });
                found += &format!("choice {known}");
                rest = &behind[end + 1..];
                continue;
            }
            let end = rest.find('}').unwrap_or(0);
            let digits: Vec<u32> = rest[..end]
                .split(|c: char| !c.is_ascii_digit())
                .filter_map(|part| part.parse().ok())
                .collect();
            rest = &rest[end + 1..];
            let [area, index] = digits[..] else { continue };
            let cell = Cell { area: AreaId(u16::try_from(area).unwrap_or(0)), index };
            found += &match area {
                4 | 5 => {
                    let next = self.between.len();
                    format!("between {}", self.between.entry(cell).or_insert(next))
                }
                _ => self.program.cell_name(cell),
            };
        }
        found += rest;
        self.lines.push(found);
        for number in std::mem::take(&mut self.open) {
            let choice = scanbound_ir::ChoiceId(number);
            let own = (
                self.program.kinds.get(&choice),
                self.program.always_followed.contains(&choice),
                self.program.statements.undefined_by_language.contains(&choice),
                self.program.timekeeping.untracked.contains(&choice),
            );
            let text = format!("meaning {own:?}");
            self.push(&text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_base::facts::Facts;

    fn both(text: &str) -> [Lowered; 2] {
        let mut project = scanbound_iec::read("main.st", text).expect("a project");
        project.inherit_parts();
        project.unqualify();
        let facts = Facts::default();
        let asked = scanbound_front::Options::new(&facts);
        let charts = names::Options::default();
        [
            names::decode(&project, super::super::TEXT, charts, &asked),
            lower::decode(&project, super::super::TEXT, charts, &asked),
        ]
    }

    fn compared(text: &str) -> String {
        let [names, tree] = both(text);
        outcome(&names, &tree)
    }

    /// What a program of each kind of construct becomes on both roads.
    #[test]
    fn both_roads_make_the_same_program() {
        let units = "TYPE S : STRUCT b : BOOL; n : INT; END_STRUCT; Colour : (red := 2, green, blue := 5); END_TYPE
            FUNCTION F : INT VAR_INPUT a : INT; k : INT := 3; END_VAR VAR_IN_OUT c : INT; END_VAR
                c := c + a; F := k; END_FUNCTION
            FUNCTION_BLOCK Base VAR_INPUT p : INT; END_VAR VAR_OUTPUT o : INT; END_VAR VAR n : INT; t : TON; END_VAR
                METHOD M : INT VAR_INPUT a : INT; END_VAR M := a + n; END_METHOD
                t(IN := p > 3, PT := T#20ms, Q => );
                IF t.Q THEN o := M(p); ELSE n := n + 1; END_IF END_FUNCTION_BLOCK
            FUNCTION_BLOCK Derived EXTENDS Base
                METHOD M : INT VAR_INPUT a : INT; END_VAR M := SUPER^.M(a) * 2; END_METHOD
                SUPER^(); o := o + 1; END_FUNCTION_BLOCK";
        let variables = "in AT %IX0.0 : BOOL; w AT %IW2 : INT; x, y, i : INT; u : UINT; d : DINT; r : REAL; c : Colour; \
            s, z : S; a : ARRAY[0..3] OF INT; m : ARRAY[1..2, 0..1] OF S; fb : Derived; all : ARRAY[0..1] OF Base; \
            cu : CTU; text : STRING(20); e : R_TRIG; on : BOOL := TRUE; k : INT := 7;";
        for body in [
            "x := y + 3 * w;",
            "r := x; d := x - u; x := REAL_TO_INT(r / 2.5);",
            "s := z; m[1, 0].n := s.n; a[w] := a[x + 1];",
            "c := green; IF c = blue OR in THEN x.3 := on; END_IF",
            "CASE w OF 1, 3..5: x := 1; 7: x := 2; ELSE x := 3; END_CASE",
            "FOR i := 1 TO w BY 2 DO IF a[i] > 3 THEN EXIT; END_IF y := y + a[i]; END_FOR",
            "WHILE i < 10 DO i := i + 1; END_WHILE REPEAT y := y - 1; UNTIL y <= 0 END_REPEAT",
            "x := F(w, c := y) + F(1, 2, y);",
            "fb(p := w, o => x); y := fb.M(3) + all[1].o; all[w](p := 2); x := all[0].M(x);",
            "cu(CU := in, PV := 5); x := cu.CV; e(CLK := in, Q => on);",
            "x := LIMIT(0, w, 10) + MAX(x, y, 3); d := SHL(u, 3); x := SEL(in, x, y); y := MUX(x, 1, 2, w);",
            "text := CONCAT(text, 'abc'); x := LEN(text); on := text = 'x';",
            "y := ADD(EN := in, IN1 := w, IN2 := 1, ENO => on);",
            "x := %IW4; %QX1.0 := in; u := WORD#16#FF AND u; on := NOT in XOR on;",
        ] {
            let text = format!("{units} PROGRAM main VAR {variables} END_VAR {body} END_PROGRAM");
            assert_eq!(compared(&text), "same", "{body}");
        }
    }

    #[test]
    fn both_roads_follow_references_alike() {
        let units = "INTERFACE I METHOD M : INT VAR_INPUT a : INT; END_VAR END_METHOD END_INTERFACE
            FUNCTION_BLOCK A IMPLEMENTS I VAR n : INT; END_VAR
                METHOD M : INT VAR_INPUT a : INT; END_VAR M := a + n; END_METHOD
                PROPERTY P : INT GET P := n; END_GET SET n := P; END_SET END_PROPERTY END_FUNCTION_BLOCK
            FUNCTION_BLOCK B IMPLEMENTS I VAR k : INT; END_VAR
                METHOD M : INT VAR_INPUT a : INT; END_VAR k := k + a; M := k; END_METHOD END_FUNCTION_BLOCK
            FUNCTION_BLOCK U VAR_INPUT r : REFERENCE TO INT; i : I; END_VAR VAR o : INT; END_VAR
                r := r + 1; o := i.M(r); END_FUNCTION_BLOCK
            FUNCTION_BLOCK C VAR p : POINTER TO INT; END_VAR
                METHOD FB_Init : BOOL VAR_INPUT a : POINTER TO INT; END_VAR p := a; END_METHOD
                IF p <> 0 THEN p^ := 1; END_IF END_FUNCTION_BLOCK";
        for body in [
            "IF in THEN p := ADR(x); ELSE p := ADR(y); END_IF p^ := p^ + 1;",
            "IF in THEN it := a; ELSE it := b; END_IF x := it.M(3); u(r := x, i := it);",
            "rr REF= arr[w]; rr := 5; y := rr; IF __ISVALIDREF(rr) THEN x := 2; END_IF",
            "a.P := b.M(2); x := a.P; y := all[w].P; all[w].P := 3;",
            "c(); many[w] := ADR(x); many[w]^ := y;",
        ] {
            let text = format!(
                "{units} PROGRAM main VAR x, y : INT; p : POINTER TO INT; arr : ARRAY[0..3] OF INT; w AT %IW2 : INT; \
                 in AT %IX0.0 : BOOL; a : A; b : B; all : ARRAY[0..2] OF A; it : I; u : U; rr : REFERENCE TO INT; \
                 c : C(a := ADR(y)); many : ARRAY[0..1] OF POINTER TO INT := [ADR(x), ADR(y)]; END_VAR {body} END_PROGRAM"
            );
            assert_eq!(compared(&text), "same", "{body}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_alike_where_it_is_executed() {
        for (body, outcome) in [
            ("x := q;", "same fault"),
            ("x := LOWER(3);", "same fault"),
            ("FOR x := 1 TO 3 DO x := 2; END_FOR", "same fault"),
            ("p^ := 1;", "same fault"),
            ("{x := 1;}", "not yet: code of other languages"),
        ] {
            let text = format!(
                "FUNCTION never : INT never := nobody; END_FUNCTION \
                 PROGRAM main VAR x : INT; a : ARRAY[0..3] OF INT; p : POINTER TO INT; END_VAR {body} END_PROGRAM"
            );
            assert_eq!(compared(&text), outcome, "{body}");
        }
    }

    /// `SCANBOUND_IEC_FILE=a.st cargo test -p scanbound-front-iec -- --ignored roads` writes both programs beside the file.
    #[test]
    #[ignore = "shows a file"]
    fn show_both() {
        let path = std::env::var("SCANBOUND_IEC_FILE").expect("a file");
        let text = std::fs::read_to_string(&path).expect("text");
        for (lowered, road) in both(&text).into_iter().zip(["names", "tree"]) {
            let lines = match lowered {
                Ok(program) => Shown::of(&program).lines,
                Err(faults) => faults.iter().map(|one| one.message.clone()).collect(),
            };
            let written = std::fs::write(format!("{path}.{road}"), lines.join("\n") + "\n");
            assert!(written.is_ok(), "{written:?}");
        }
    }
}
