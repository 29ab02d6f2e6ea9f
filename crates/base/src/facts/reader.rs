//! Reads a facts file.

use super::calls::{StatedCall, normalized};
use super::places::FactPositions;
use super::{ActionOrder, Facts, InterruptRate, StatedFactor};
use crate::checksum::sha256;
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::time::Picos;
use std::cmp::Ordering;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The syntax of a facts file, shown as help for an entry that does not follow it.
const FORM: &str = "a facts file has these tables, with entries such as [ranges] (D100 = [0, 10]), [counts] (\"MAIN.csv:543\" = [0, 20]), [calls] (P153 = { time = \"50us\", writes = [\"D100-D199\"] }), [interrupts] (I0 = 2, I28 = \"4ms\"), [io] (inputs = 64, outputs = 32, base = \"main\", latched = true), [network] (refresh = \"1ms\" or \"none\"), [index] (bits = 16, Z0 = [0, 99], indirect = [\"ZR1000-ZR1999\"]), [devices] (ZR = 200000, L = 32768), [scan] (factor = 1.1, constant = \"20ms\" or \"none\", watchdog = \"500ms\", on_error = \"stop\"), [external] and [internal] (devices = [\"D100-D199\"]), [exclusive] (sets = [[\"X10\", \"X11\"]]), [start] (download = true), [sfc] (selection = \"all\", action_order = \"named\", drawn_conditions = \"last-scan\") and [controller] (\"actions have no final scan\" = true)";
const SCAN: &str = "write factor = 1.1 if other tasks of the CPU, such as communication, lengthen a scan by at most 10 %; constant = \"20ms\", the constant or minimum scan time in the CPU's parameters, or \"none\"; watchdog = \"500ms\", the watchdog time in the CPU's parameters";
const DOWNLOAD: &str = "write download = true if the bound must also cover the first scans after a download, in which memory may have any values";
const SELECTION: &str = "write selection = \"all\" if all true transitions after a step fire where they have no priorities, or selection = \"first\" if only the first of them fires";
const DRAWN: &str = "write drawn_conditions = \"last-scan\" if the controller executes blocks in the drawn conditions of a chart in each scan, and the conditions read the outputs of the previous scan (Beremiz, OpenPLC)";
const ACTION_ORDER: &str = "write the order in which actions are executed: action_order = \"named\" (the order in which the chart first names them), \"declared\" (Boolean variables, then actions in the order of declaration: matiec) or \"alphabetical\" (first the actions that have just ended, then the others, each of the two in the order of their names: CODESYS, TwinCAT)";
const ON_ERROR: &str = "write on_error = \"stop\" if the CPU's parameters say that it stops at an operation error (division by zero, index out of range), or on_error = \"continue\" if it continues";
const CONTROLLER: &str = "write true if the controller does this, false if it does as the standard says: \"actions have no final scan\" = true";
/// The names of the tables that a facts file may have.
pub const TABLES: [&str; 15] = [
    "ranges",
    "counts",
    "calls",
    "interrupts",
    "io",
    "network",
    "index",
    "devices",
    "scan",
    "external",
    "internal",
    "exclusive",
    "start",
    "sfc",
    "controller",
];
/// The largest number of errors that are listed. Further ones are only counted.
const MAX_FAULTS: usize = 100;
/// The longest network refresh time, and the longest time of a missing routine, that is accepted: 10 s.
const LONGEST: Picos = Picos(10_000_000_000_000);
/// The longest watchdog time, and the longest constant scan time, that is accepted: 60 s.
const LONGEST_CYCLE: Picos = Picos(60_000_000_000_000);
/// The largest factor on the scan time that is accepted: 10, in millionths.
const LARGEST_FACTOR: u64 = 10_000_000;

impl Facts {
    /// Reads a facts file in TOML. `name` is the file's name in error messages.
    ///
    /// # Errors
    /// All errors of the file, sorted by line. Beyond 100, the further ones are only counted.
    ///
    /// # Examples
    /// ```
    /// use scanbound_base::facts::Facts;
    ///
    /// let facts = Facts::parse("facts.toml", "[interrupts]\nI0 = 2\n").expect("right facts");
    /// assert_eq!(facts.interrupt("I0"), Some(2));
    /// let faults = Facts::parse("facts.toml", "[interrupts]\nI0 = -1\n").expect_err("a negative number");
    /// assert_eq!(faults.len(), 1);
    /// ```
    pub fn parse(name: &str, text: &str) -> Result<Facts, Vec<Diagnostic>> {
        let read_from = Some((name.to_owned(), sha256(text.as_bytes())));
        let facts = Facts { read_from, places: FactPositions::new(name, text), ..Facts::default() };
        let mut reader = Reader { name, facts, faults: Vec::new(), dropped: 0 };
        let (table, errors) = DeTable::parse_recoverable(text);
        for error in errors {
            let help = match error.message() {
                "duplicate key" => "write each table once, and each key of a table once",
                _ => FORM,
            };
            reader.fault(error.span(), format!("not TOML: {}", error.message()), help);
        }
        for (key, value) in table.get_ref() {
            let name = key.get_ref().as_ref();
            match value.get_ref().as_table() {
                Some(entries) if TABLES.contains(&name) => {
                    for (own, value) in entries {
                        reader.facts.places.record(name, own.get_ref(), [own.span(), value.span()]);
                        reader.fact(name, own, value);
                    }
                }
                None if TABLES.contains(&name) => {
                    reader.fault(Some(key.span()), format!("'{name}' must be a table"), FORM);
                }
                _ => {
                    let message = format!("[{name}] is not a table of a facts file");
                    reader.fault(Some(key.span()), message, &help_for_unknown(name, &TABLES, FORM));
                }
            }
        }
        reader.finish()
    }
}

struct Reader<'a> {
    name: &'a str,
    facts: Facts,
    faults: Vec<Diagnostic>,
    dropped: usize,
}

/// A key with its byte range in the file.
type Key<'a> = Spanned<std::borrow::Cow<'a, str>>;
type Value<'a> = Spanned<DeValue<'a>>;

impl Reader<'_> {
    fn finish(mut self) -> Result<Facts, Vec<Diagnostic>> {
        self.faults.sort_by_key(|fault| fault.line);
        if self.dropped > 0 {
            let message = format!("{} more errors are not listed", self.dropped);
            let help = "correct the listed errors first";
            self.faults.push(Diagnostic::file(Code::Facts, self.name, message, help));
        }
        if self.faults.is_empty() { Ok(self.facts) } else { Err(self.faults) }
    }

    fn call(&mut self, name: &str, value: &Value<'_>) {
        const HELP: &str = "write P153 = { time = \"50us\", writes = [\"D100-D199\"] }: the longest time of the routine, and all devices that it writes; without writes, it may write any device";
        let Some(entries) = value.get_ref().as_table() else {
            let message = format!("the facts about the routine {name} must be in braces");
            return self.fault(Some(value.span()), message, HELP);
        };
        let (mut time, mut writes) = (None, None);
        for (key, value) in entries {
            let known = match key.get_ref().as_ref() {
                "time" => {
                    let text = value.get_ref().as_str();
                    let read = text.and_then(|text| Picos::from_duration_text(text).ok());
                    time = read.filter(|&time| time <= LONGEST);
                    time.is_some()
                }
                "writes" => {
                    let text = |one: &Value<'_>| Some(one.get_ref().as_str()?.to_owned());
                    let all = value.get_ref().as_array();
                    writes = all.and_then(|all| all.iter().map(text).collect());
                    writes.is_some()
                }
                other => {
                    let message = format!("'{other}' is not a key of a routine in [calls]");
                    self.fault(
                        Some(key.span()),
                        message,
                        &help_for_unknown(other, &["time", "writes"], HELP),
                    );
                    continue;
                }
            };
            if !known {
                let message = match key.get_ref().as_ref() {
                    "time" => format!(
                        "the time of the routine {name} must be at most 10 s, in quotes with its unit"
                    ),
                    _ => format!("writes of {name} must be a list of devices"),
                };
                self.fault(Some(value.span()), message, HELP);
            }
        }
        let Some(time) = time else {
            if !entries.iter().any(|(key, _)| key.get_ref() == "time") {
                let message = format!("the longest execution time of {name} is not stated");
                self.fault(Some(value.span()), message, HELP);
            }
            return;
        };
        let call = StatedCall { name: name.to_owned(), time, writes };
        let first = self.facts.calls.insert(normalized(name), call);
        if let Some(first) = first {
            let message =
                format!("[calls] states the same routine twice, as {name} and as {}", first.name);
            self.fault(Some(value.span()), message, "state the facts of each routine once");
        }
    }

    fn fact(&mut self, table: &str, key: &Key<'_>, value: &Value<'_>) {
        match table {
            "ranges" => self.range(key.get_ref(), value),
            "counts" => self.counted(key.get_ref(), value),
            "calls" => self.call(key.get_ref(), value),
            "index" => self.index(key, value),
            "devices" => {
                let what = format!("the number of devices {}", key.get_ref());
                if let Some(count) = self.count(&what, value) {
                    self.facts.devices.insert(key.get_ref().to_string(), count);
                }
            }
            "interrupts" if value.get_ref().as_str().is_some() => {
                let text = value.get_ref().as_str().unwrap_or_default().trim();
                match text.parse() {
                    Ok(InterruptRate::Every(interval)) => {
                        let label = key.get_ref().to_ascii_uppercase();
                        self.facts.intervals.insert(label, interval);
                    }
                    _ => {
                        let message = format!(
                            "the interval of the interrupt {} must be a time above 0",
                            key.get_ref()
                        );
                        let help = "write the interval in quotes, such as I28 = \"4ms\", or the number of interrupts in one scan, such as I28 = 2";
                        self.fault(Some(value.span()), message, help);
                    }
                }
            }
            "interrupts" => {
                if let Some(times) =
                    self.count(&format!("the number of interrupts of {}", key.get_ref()), value)
                {
                    let most = self.facts.interrupts.entry(key.get_ref().to_ascii_uppercase());
                    let most = most.or_insert(times);
                    *most = (*most).max(times);
                }
            }
            "io" => self.points(key, value),
            "network" => self.network(key, value),
            "external" => {
                let help = "write devices = [\"D100-D199\", \"M50\"], the devices that HMIs and other stations write between scans";
                if let Some(devices) = self.devices(table, key, value, help) {
                    self.facts.external = devices;
                }
            }
            "internal" => {
                let help = "write devices = [\"D100-D199\", \"M50\"], the devices that only the program writes";
                if let Some(devices) = self.devices(table, key, value, help) {
                    self.facts.internal = devices;
                }
            }
            "exclusive" => self.exclusive(key, value),
            "start" => match (key.get_ref().as_ref(), value.get_ref().as_bool()) {
                ("download", Some(download)) => self.facts.download = download,
                ("download", None) => self.fault(
                    Some(value.span()),
                    "download in [start] must be true or false".to_owned(),
                    DOWNLOAD,
                ),
                (other, _) => {
                    self.unknown(key, "start", &help_for_unknown(other, &["download"], DOWNLOAD))
                }
            },
            "sfc" => self.chart(key, value),
            "controller" => match value.get_ref().as_bool() {
                Some(holds) => _ = self.facts.controller.insert(key.get_ref().to_string(), holds),
                None => {
                    let message =
                        format!("'{}' in [controller] must be true or false", key.get_ref());
                    self.fault(Some(value.span()), message, CONTROLLER);
                }
            },
            _ => self.scan(key, value),
        }
    }

    fn chart(&mut self, key: &Key<'_>, value: &Value<'_>) {
        let text = value.get_ref().as_str();
        match key.get_ref().as_ref() {
            "selection" => match text {
                Some("all") => self.facts.all_clear = Some(true),
                Some("first") => self.facts.all_clear = Some(false),
                _ => {
                    let message = "selection must be \"first\" or \"all\"".to_owned();
                    self.fault(Some(value.span()), message, SELECTION);
                }
            },
            "drawn_conditions" => {
                self.facts.drawn_last_scan = text == Some("last-scan");
                if !self.facts.drawn_last_scan {
                    let message = "drawn_conditions must be \"last-scan\"".to_owned();
                    self.fault(Some(value.span()), message, DRAWN);
                }
            }
            "action_order" => {
                let named = |one: &ActionOrder| text == Some(one.name());
                self.facts.action_order = ActionOrder::ALL.into_iter().find(named);
                if self.facts.action_order.is_none() {
                    let message =
                        "action_order must be \"named\", \"declared\" or \"alphabetical\""
                            .to_owned();
                    self.fault(Some(value.span()), message, ACTION_ORDER);
                }
            }
            other => {
                let help = format!("{SELECTION}; {ACTION_ORDER}; {DRAWN}");
                let keys = ["selection", "action_order", "drawn_conditions"];
                self.unknown(key, "sfc", &help_for_unknown(other, &keys, &help));
            }
        }
    }

    fn range(&mut self, device: &str, value: &Value<'_>) {
        match numbers(value).as_deref() {
            Some(&[low, high]) if low <= high => {
                self.facts.ranges.insert(device.to_owned(), (low, high));
            }
            Some(&[low, high]) => self.fault(
                Some(value.span()),
                format!("the range of {device} is empty: {low} is above {high}"),
                "write the smaller number first",
            ),
            _ => self.fault(
                Some(value.span()),
                format!(
                    "the range of {device} must be two integers, [min, max], with min not above max"
                ),
                "write D100 = [0, 10]; put a device with a point in its name in quotes: \"D10.A\"",
            ),
        }
    }

    fn counted(&mut self, place: &str, value: &Value<'_>) {
        let item = |value: &DeValue<'_>| integer(value).filter(|count| *count >= 0);
        let numbers: Option<Vec<i64>> = match value.get_ref().as_array() {
            Some(array) => array.iter().map(|one| item(one.get_ref())).collect(),
            None => item(value.get_ref()).map(|count| vec![count, count]),
        };
        match numbers.as_deref() {
            Some(&[low, high]) if low <= high => {
                self.facts.counts.insert(place.to_owned(), (low, high));
            }
            _ => self.fault(
                Some(value.span()),
                format!("'{place}' in [counts] must be a non-negative integer or [min, max]"),
                "write \"MAIN.csv:543\" = 20 if that instruction always has 20 iterations or units, or \"MAIN.csv:543\" = [0, 20] if it has at most 20",
            ),
        }
    }

    fn index(&mut self, key: &Key<'_>, value: &Value<'_>) {
        match key.get_ref().as_ref() {
            "bits" => match integer(value.get_ref()) {
                Some(16) => self.facts.index_bits = Some(16),
                Some(32) => self.facts.index_bits = Some(32),
                _ => self.fault(
                    Some(value.span()),
                    "bits in [index] must be 16 or 32".to_owned(),
                    "write bits = 16 or bits = 32: the size of an index to file registers (ZR) in the CPU's parameters",
                ),
            },
            "indirect" => {
                let text = |one: &Value<'_>| Some(one.get_ref().as_str()?.to_owned());
                let all = value.get_ref().as_array().map(|all| all.iter().map(text).collect());
                match all {
                    Some(Some(devices)) => self.facts.indirect = Some(devices),
                    _ => self.fault(
                        Some(value.span()),
                        "indirect in [index] must be a list of devices".to_owned(),
                        "write indirect = [\"ZR1000-ZR1999\", \"D500\"], all devices that the program writes through indirect addresses (@)",
                    ),
                }
            }
            place if value.get_ref().as_array().is_some() => {
                match numbers(value).as_deref() {
                    Some(&[low, high]) if low <= high => {
                        self.facts.indices.insert(place.to_owned(), (low, high));
                    }
                    _ => self.fault(
                        Some(value.span()),
                        format!("the range of the index '{place}' must be two integers, [min, max], with min not above max"),
                        "write Z0 = [0, 99], or \"MAIN.csv:924\" = [0, 99]",
                    ),
                }
            }
            other => {
                let help = "write bits = 16, Z0 = [0, 99], or indirect = [\"ZR1000-ZR1999\"]";
                self.unknown(key, "index", &help_for_unknown(other, &["bits", "indirect"], help));
            }
        }
    }

    /// Reads an entry of a table whose only content is `devices`, a list of devices. `None` if an error was reported.
    fn devices(
        &mut self,
        table: &str,
        key: &Key<'_>,
        value: &Value<'_>,
        help: &str,
    ) -> Option<Vec<String>> {
        if key.get_ref().as_ref() != "devices" {
            self.unknown(key, table, &help_for_unknown(key.get_ref(), &["devices"], help));
            return None;
        }
        let text = |one: &Value<'_>| Some(one.get_ref().as_str()?.to_owned());
        let devices = value.get_ref().as_array().and_then(|all| all.iter().map(text).collect());
        if devices.is_none() {
            self.fault(
                Some(value.span()),
                "'devices' must be a list of device names in quotes".to_owned(),
                help,
            );
        }
        devices
    }

    fn exclusive(&mut self, key: &Key<'_>, value: &Value<'_>) {
        let help = "write sets = [[\"X10\", \"X11\"], [\"M100\", \"M101\", \"M102\"]], where no two bits of a set are on at the same time when a scan starts";
        if key.get_ref().as_ref() != "sets" {
            return self.unknown(
                key,
                "exclusive",
                &help_for_unknown(key.get_ref(), &["sets"], help),
            );
        }
        let text = |one: &Value<'_>| Some(one.get_ref().as_str()?.to_owned());
        let set = |one: &Value<'_>| {
            let bits: Vec<String> =
                one.get_ref().as_array()?.iter().map(text).collect::<Option<_>>()?;
            (bits.len() > 1).then_some(bits)
        };
        match value.get_ref().as_array().and_then(|all| all.iter().map(set).collect()) {
            Some(sets) => self.facts.exclusive = sets,
            None => {
                let message =
                    "sets must be a list of lists, each with at least two bits".to_owned();
                self.fault(Some(value.span()), message, help);
            }
        }
    }

    fn points(&mut self, key: &Key<'_>, value: &Value<'_>) {
        match key.get_ref().as_ref() {
            "inputs" => self.facts.inputs = self.side(0, "inputs", value),
            "outputs" => self.facts.outputs = self.side(1, "outputs", value),
            "base" => match value.get_ref().as_str() {
                Some(base) => self.facts.base = Some(base.trim().to_ascii_lowercase()),
                None => self.fault(
                    Some(value.span()),
                    "base in [io] must be a string in quotes".to_owned(),
                    "write base = \"main\", the type of base unit that holds all I/O modules",
                ),
            },
            "latched" => match value.get_ref().as_bool() {
                Some(latched) => self.facts.latched = Some(latched),
                None => self.fault(
                    Some(value.span()),
                    "latched in [io] must be true or false".to_owned(),
                    "write latched = true if the PLC copies its inputs to an image once at the start of each pass",
                ),
            },
            other => self.unknown(
                key,
                "io",
                &help_for_unknown(
                    other,
                    &["inputs", "outputs", "base", "latched"],
                    "write inputs = 64 and outputs = 32, the points that the CPU refreshes",
                ),
            ),
        }
    }

    /// Reads the number of input or output points (`side` 0 or 1): one number, or one number for each type of base
    /// unit. Returns the sum; `None` if an error was reported.
    fn side(&mut self, side: usize, name: &str, value: &Value<'_>) -> Option<u32> {
        let Some(bases) = value.get_ref().as_table() else { return self.count(name, value) };
        let mut sum = Some(0_u32);
        for (base, points) in bases {
            let own = self.count(&format!("{name} on the base unit {}", base.get_ref()), points)?;
            let own_name = base.get_ref().trim().to_ascii_lowercase();
            let key = format!("{name}.{own_name}");
            self.facts.places.record("io", &key, [base.span(), points.span()]);
            let on_base = self.facts.by_base[side].entry(own_name).or_default();
            *on_base = on_base.saturating_add(own);
            sum = sum.and_then(|sum| sum.checked_add(own));
        }
        if sum.is_none() {
            let message = format!("the sum of the {name} on all base units is too large");
            self.fault(
                Some(value.span()),
                message,
                "correct the number of points of each base unit",
            );
        }
        sum
    }

    fn network(&mut self, key: &Key<'_>, value: &Value<'_>) {
        let help = "write refresh = \"1.5ms\", the longest time that the refresh of all networks takes in one scan, or refresh = \"none\" if there is no network";
        if key.get_ref().as_ref() != "refresh" {
            return self.unknown(
                key,
                "network",
                &help_for_unknown(key.get_ref(), &["refresh"], help),
            );
        }
        let text = value.get_ref().as_str().map(str::trim);
        let time = match text {
            Some(none) if none.eq_ignore_ascii_case("none") => Some(Picos::ZERO),
            Some(text) => text.parse().ok().filter(|&time| time <= LONGEST),
            None => None,
        };
        match time {
            Some(time) => self.facts.network = Some(time),
            None => self.fault(
                Some(value.span()),
                "refresh in [network] must be \"none\", or a time of at most 10 s, in quotes with its unit"
                    .to_owned(),
                help,
            ),
        }
    }

    fn scan(&mut self, key: &Key<'_>, value: &Value<'_>) {
        let help = match key.get_ref().as_ref() {
            "factor" => {
                "write factor = 1.1 if other tasks of the CPU, such as communication, lengthen a scan by at most 10 %"
            }
            "on_error" => return self.on_error(value),
            "constant" | "watchdog" => return self.scan_time(key.get_ref(), value),
            other => {
                let known = ["factor", "constant", "watchdog", "on_error"];
                return self.unknown(
                    key,
                    "scan",
                    &help_for_unknown(other, &known, &format!("{SCAN}; {ON_ERROR}")),
                );
            }
        };
        let text = match value.get_ref() {
            DeValue::Float(float) => float.as_str().to_owned(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().to_owned(),
            DeValue::String(text) => text.trim().to_owned(),
            _ => String::new(),
        };
        let allowed = 1_000_000..=LARGEST_FACTOR;
        match Picos::from_us_text(&text) {
            Ok(Picos(millionths)) if allowed.contains(&millionths) => {
                self.facts.factor = Some(StatedFactor { millionths, text });
            }
            _ => self.fault(
                Some(value.span()),
                "factor in [scan] must be a decimal number from 1 to 10".to_owned(),
                help,
            ),
        }
    }

    fn on_error(&mut self, value: &Value<'_>) {
        match value.get_ref().as_str() {
            Some("stop") => self.facts.stops_on_error = Some(true),
            Some("continue") => self.facts.stops_on_error = Some(false),
            _ => {
                let message = "on_error must be \"stop\" or \"continue\"".to_owned();
                self.fault(Some(value.span()), message, ON_ERROR);
            }
        }
    }

    /// Reads the time of the key `name` in `[scan]`: `constant` (the constant scan time, or "none") or `watchdog`.
    fn scan_time(&mut self, name: &str, value: &Value<'_>) {
        let text = value.get_ref().as_str().map_or("", str::trim);
        let is_none = name == "constant" && text.eq_ignore_ascii_case("none");
        let time = if is_none { Some(Picos::ZERO) } else { text.parse().ok() };
        let time = time.filter(|&time| time <= LONGEST_CYCLE && (is_none || time > Picos::ZERO));
        match (name, time) {
            ("constant", Some(time)) => self.facts.constant_scan = Some(time),
            (_, Some(time)) => self.facts.watchdog = Some(time),
            (_, None) => {
                let none = if name == "constant" { "\"none\", or " } else { "" };
                let message = format!(
                    "{name} must be {none}a time above 0 and at most 60 s, in quotes with its unit"
                );
                self.fault(Some(value.span()), message, SCAN);
            }
        }
    }

    fn unknown(&mut self, key: &Key<'_>, table: &str, help: &str) {
        let message = format!("[{table}] cannot have a key '{}'", key.get_ref());
        self.fault(Some(key.span()), message, help);
    }

    fn count(&mut self, what: &str, value: &Value<'_>) -> Option<u32> {
        let number = integer(value.get_ref()).and_then(|n| u32::try_from(n).ok());
        if number.is_none() {
            self.fault(
                Some(value.span()),
                format!("{what} must be a whole number from 0 on"),
                "write the number without quotes, such as 2",
            );
        }
        number
    }

    fn fault(&mut self, span: Option<Range<usize>>, message: String, help: &str) {
        if self.faults.len() >= MAX_FAULTS {
            self.dropped += 1;
            return;
        }
        self.faults.push(match span {
            Some(span) => self.facts.places.at(Code::Facts, span, message, help),
            None => Diagnostic::file(Code::Facts, self.name, message, help),
        });
    }
}

/// The help text, preceded by "did you mean NAME?" if a known name is similar to the wrong one.
fn help_for_unknown(wrong: &str, known: &[&str], help: &str) -> String {
    let likeness =
        |name: &&&str| Some(strsim::jaro_winkler(wrong, name)).filter(|&likeness| likeness > 0.8);
    let nearest = known.iter().filter(|name| likeness(name).is_some());
    let nearest =
        nearest.max_by(|a, b| likeness(a).partial_cmp(&likeness(b)).unwrap_or(Ordering::Equal));
    nearest.map_or(String::new(), |name| format!("did you mean {name}? ")) + help
}

/// The elements of an array of integers; `None` if the value is anything else.
fn numbers(value: &Value<'_>) -> Option<Vec<i64>> {
    value.get_ref().as_array()?.iter().map(|item| integer(item.get_ref())).collect()
}

fn integer(value: &DeValue<'_>) -> Option<i64> {
    let number = value.as_integer()?;
    i64::from_str_radix(number.as_str(), number.radix()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facts::Part;
    use std::collections::BTreeMap;

    #[test]
    fn every_fact_is_read() {
        let text = "[ranges]\nD100 = [0, 10]\n'Z0' = [-1, 0x1F]\n[counts]\n'A.csv:7' = [0, 9]\n'A.csv:9' = 3\n[calls]\np007 = { time = '2us', writes = ['D1-D9'] }\n[index]\nbits = 32\nindirect = ['D1-D9', 'W5']\nZ3 = [-4, 9]\n[devices]\nZR = 200000\n[interrupts]\nI0 = 2\nI28 = '4ms'\n[io]\ninputs = 64\noutputs = 32\nlatched = true\nbase = 'Main'\n[network]\nrefresh = '1.5ms'\n[scan]\nfactor = 1.05\nconstant = 'none'\nwatchdog = '0.5s'\non_error = 'continue'\n[external]\ndevices = ['D5']\n[internal]\ndevices = ['M1-M9']\n[exclusive]\nsets = [['X1', 'X2'], ['M1', 'M2', 'M3']]\n[start]\ndownload = true\n[sfc]\nselection = 'all'\naction_order = 'alphabetical'\ndrawn_conditions = 'last-scan'\n[controller]\n'actions have no final scan' = true\n";
        let facts = Facts::parse("facts.toml", text).expect("the facts are well-formed");
        let writes = Some(vec!["D1-D9".to_owned()]);
        let call = StatedCall { name: "p007".to_owned(), time: Picos(2_000_000), writes };
        assert_eq!(
            facts,
            Facts {
                read_from: Some(("facts.toml".to_owned(), sha256(text.as_bytes()))),
                ranges: [("D100".to_owned(), (0, 10)), ("Z0".to_owned(), (-1, 31))].into(),
                counts: [("A.csv:7".to_owned(), (0, 9)), ("A.csv:9".to_owned(), (3, 3))].into(),
                calls: [("P7".to_owned(), call)].into(),
                index_bits: Some(32),
                devices: [("ZR".to_owned(), 200_000)].into(),
                indirect: Some(vec!["D1-D9".to_owned(), "W5".to_owned()]),
                indices: [("Z3".to_owned(), (-4, 9))].into(),
                external: vec!["D5".to_owned()],
                internal: vec!["M1-M9".to_owned()],
                exclusive: [&["X1", "X2"][..], &["M1", "M2", "M3"]]
                    .map(|set| set.iter().map(|one| (*one).to_owned()).collect())
                    .into(),
                download: true,
                all_clear: Some(true),
                action_order: Some(ActionOrder::Alphabetical),
                drawn_last_scan: true,
                controller: [("actions have no final scan".to_owned(), true)].into(),
                interrupts: [("I0".to_owned(), 2)].into(),
                intervals: [("I28".to_owned(), Picos(4_000_000_000))].into(),
                inputs: Some(64),
                outputs: Some(32),
                base: Some("main".to_owned()),
                by_base: Default::default(),
                network: Some(Picos(1_500_000_000)),
                factor: Some(StatedFactor { millionths: 1_050_000, text: "1.05".to_owned() }),
                stops_on_error: Some(false),
                constant_scan: Some(Picos::ZERO),
                watchdog: Some(Picos(500_000_000_000)),
                latched: Some(true),
                places: facts.places.clone(),
            }
        );
        assert_eq!((facts.interrupt("i0"), facts.interrupt("I1")), (Some(2), None));
        let read_from = Some(("facts.toml".to_owned(), sha256(b"")));
        let empty =
            Facts { read_from, places: FactPositions::new("facts.toml", ""), ..Facts::default() };
        assert_eq!(Facts::parse("facts.toml", ""), Ok(empty));
    }

    #[test]
    fn points_are_stated_by_base_too_and_no_network_is_none() {
        let text = "[io]\ninputs = { main = 32, Extension = 16 }\n[network]\nrefresh = 'none'\n[scan]\nfactor = 2\n";
        let facts = Facts::parse("facts.toml", text).expect("facts");
        assert_eq!((facts.inputs, facts.outputs), (Some(48), None));
        let bases = [("main".to_owned(), 32), ("extension".to_owned(), 16)];
        assert_eq!(facts.by_base, [bases.into(), BTreeMap::new()]);
        assert_eq!(facts.network, Some(Picos::ZERO));
        assert_eq!(facts.factor.map(|factor| factor.millionths), Some(2_000_000));
        for wrong in [
            "[network]\nrefresh = 5",
            "[network]\nrefresh = '11s'",
            "[network]\nrefresh = '-1ms'",
            "[network]\ntime = '1ms'",
            "[scan]\nfactor = 0.9",
            "[scan]\nfactor = 11",
            "[scan]\nfactor = 1e1",
            "[io]\nbase = 1",
            "[io]\ninputs = { main = -1 }",
            "[io]\ninputs = { a = 4294967295, b = 1 }",
        ] {
            let faults = Facts::parse("facts.toml", wrong).expect_err(wrong);
            assert_eq!(faults.iter().map(|fault| fault.line).collect::<Vec<_>>(), [Some(2)]);
        }
    }

    #[test]
    fn faults_found_later_mark_the_key_or_the_value() {
        let long = " ".repeat(1000);
        let text = format!("[ranges]\r\n\"D 1\" = [3, 4]\r\nD2 ={long}[5, 6]\r\n");
        let facts = Facts::parse("facts.toml", &text).expect("facts");
        let marked = |key, part| {
            let fault = facts.fault(["ranges", key], part, Code::Fact, "wrong", "help");
            let (from, to) = fault.span.expect("a span");
            (fault.line, fault.text[from..to].to_owned())
        };
        assert_eq!(marked("D 1", Part::Key), (Some(2), "\"D 1\"".to_owned()));
        assert_eq!(marked("D 1", Part::Value), (Some(2), "[3, 4]".to_owned()));
        assert_eq!(marked("D2", Part::Value), (Some(3), "[5, 6]".to_owned()));
        let unknown = facts.fault(["ranges", "D3"], Part::Key, Code::Fact, "wrong", "help");
        assert_eq!((unknown.file.as_str(), unknown.line), ("", None));
    }

    #[test]
    fn many_faults_are_counted() {
        let text: String = (0..500).map(|n| format!("[a{n}]\n")).collect();
        let faults = Facts::parse("facts.toml", &text).expect_err("500 faults");
        assert_eq!(faults.len(), MAX_FAULTS + 1);
        assert_eq!(faults[MAX_FAULTS].message, "400 more errors are not listed");
    }

    #[test]
    fn all_faults_are_told_at_once_in_order() {
        let text = "speed = 3\n[ranges]\nD1 = [3, 1]\nD2 = 5\n[interrupts]\nI0 = -1\n[io]\nmodules = 3\nlatched = 1\n";
        let faults = Facts::parse("facts.toml", text).expect_err("six faults");
        let told: Vec<(Option<u32>, &str)> =
            faults.iter().map(|fault| (fault.line, fault.message.as_str())).collect();
        assert_eq!(
            told,
            [
                (Some(1), "[speed] is not a table of a facts file"),
                (Some(3), "the range of D1 is empty: 3 is above 1"),
                (
                    Some(4),
                    "the range of D2 must be two integers, [min, max], with min not above max"
                ),
                (Some(6), "the number of interrupts of I0 must be a whole number from 0 on"),
                (Some(8), "[io] cannot have a key 'modules'"),
                (Some(9), "latched in [io] must be true or false"),
            ]
        );
        assert_eq!(faults[1].text, "D1 = [3, 1]");
        assert_eq!(faults[1].span, Some((5, 11)));
    }

    #[test]
    fn what_is_not_toml_is_told_with_its_line() {
        let faults =
            Facts::parse("facts.toml", "[ranges]\nD1 = [0, 1\nD2 == 3\n").expect_err("not TOML");
        assert!(faults.iter().all(|fault| fault.line.is_some()));
        assert!(faults.iter().any(|fault| fault.message.starts_with("not TOML")));
    }
}
