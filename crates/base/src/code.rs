//! The codes of findings: short names that do not change when the wording does, so that a CI pipeline can refer to
//! them. Each code has a page in `codes`.

use std::fmt;

/// Defines the codes from one list: for each, a one-line summary and the name.
macro_rules! codes {
    ($(#[doc = $summary:literal] $code:ident = $name:literal,)*) => {
        /// The stable name of one type of finding.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code {
            $(#[doc = $summary] $code,)*
        }

        impl Code {
            /// All codes, sorted by name.
            pub const ALL: &[Code] = &[$(Code::$code,)*];

            /// The name as reports and JSON write it.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Code::$code => $name,)*
                }
            }

            /// The page of documentation about the code: its meaning, an example, what to do.
            #[must_use]
            pub const fn page(self) -> &'static str {
                match self {
                    $(Code::$code => include_str!(concat!("../codes/", $name, ".md")),)*
                }
            }

            /// The meaning in one line.
            #[must_use]
            pub fn summary(self) -> &'static str {
                match self {
                    $(Code::$code => $summary.trim_ascii(),)*
                }
            }
        }
    };
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

codes! {
    /// An instruction stands after the END of its program
    AfterEnd = "after-end",
    /// A time rests on an assumption, and `--strict-times` refuses those
    AssumedTime = "assumed-time",
    /// An operand has a form that the instruction does not take
    BadOperand = "bad-operand",
    /// An address, or a label, has no instruction after it
    BareAddress = "bare-address",
    /// A step number has no instruction after it
    BareStep = "bare-step",
    /// Instructions stand after a subroutine, where the PLC does not run them
    BehindSubroutine = "behind-subroutine",
    /// A record stands after the end of an Intel HEX file
    BehindTheEnd = "behind-the-end",
    /// A file is binary data, or a tool's own file
    BinaryFile = "binary-file",
    /// A rung joins branches that are not open, or leaves branches open
    Branches = "branches",
    /// A project file ends too early, or contains no program
    BrokenProject = "broken-project",
    /// A file of measurements cannot be read
    Capture = "capture",
    /// A sequential function chart is not consistent
    Chart = "chart",
    /// A row has more or fewer columns than the heading of the table
    Columns = "columns",
    /// A comment ends at another place if comments nest than if they do not
    Comments = "comments",
    /// Only device comments were given, and no program
    CommentsAlone = "comments-alone",
    /// A connection in a drawn program leads nowhere, or forms a circle
    Connection = "connection",
    /// A loop and a master control region or a step ladder state overlap
    CrossedMasterControl = "crossed-master-control",
    /// A name is declared twice, or the program does not say which of several things it means
    DeclaredTwice = "declared-twice",
    /// A label is defined twice
    DoubleLabel = "double-label",
    /// A file is empty
    EmptyFile = "empty-file",
    /// A program of the project has no instructions
    EmptyProgram = "empty-program",
    /// A file contains bytes that are not text in its encoding
    Encoding = "encoding",
    /// An instruction has one operand too many
    ExtraOperand = "extra-operand",
    /// A scan ends in a state that contradicts a stated fact
    BrokenFact = "broken-fact",
    /// A stated fact does not fit the program or the PLC
    Fact = "fact",
    /// The facts file cannot be used, or no scan satisfies its facts
    Facts = "facts",
    /// An instruction's name and its function number disagree
    FunctionNumber = "function-number",
    /// A group's number is out of range
    GroupNumber = "group-number",
    /// Two groups have the same number
    GroupTwice = "group-twice",
    /// A line is not an Intel HEX record that can be used here
    HexRecord = "hex-record",
    /// The main routine can stay in an inner loop, each iteration of which counts as a pass
    InnerLoop = "inner-loop",
    /// The begin and the end of an interlock do not match
    Interlock = "interlock",
    /// A jump and its target do not match, or the jump goes back
    Jump = "jump",
    /// A jump goes into or out of a master control region or a step ladder state
    JumpAcrossMasterControl = "jump-across-master-control",
    /// A jump goes back, so nothing bounds the scan
    JumpBack = "jump-back",
    /// GJ stands inside a group, where its meaning is not defined
    JumpInGroup = "jump-in-group",
    /// A jump goes into a loop of FOR and NEXT
    JumpIntoLoop = "jump-into-loop",
    /// A jump leads out of its routine
    JumpOut = "jump-out",
    /// A label is defined twice in a flowchart
    LabelTwice = "label-twice",
    /// A file was left out that may belong to the scan
    LeftOut = "left-out",
    /// A line is far longer than an instruction
    LongLine = "long-line",
    /// The begin and the end of a loop do not match, or the loop makes too many iterations
    Loop = "loop",
    /// The number of iterations of a loop is unknown, or is not a permitted number
    LoopCount = "loop-count",
    /// A condition combines a timer with other tests
    MixedCondition = "mixed-condition",
    /// Files of two dialects were given as one project
    MixedDialects = "mixed-dialects",
    /// A file has more errors than are listed
    MoreErrors = "more-errors",
    /// A file has more warnings than are listed
    MoreWarnings = "more-warnings",
    /// The order in which the programs run is not known
    NameOrder = "name-order",
    /// A file was named twice
    NamedTwice = "named-twice",
    /// A subdirectory was not read
    NestedDirectory = "nested-directory",
    /// Calls or loops are nested too deeply
    Nesting = "nesting",
    /// An address of a net is missing, given twice, or of the wrong kind
    NetAddress = "net-address",
    /// An arc or gate of a net connects elements that cannot be connected
    NetArc = "net-arc",
    /// An element of a net has no arcs, or too many
    NetElement = "net-element",
    /// A name of a net is not defined, or is used for two elements
    NetName = "net-name",
    /// A line is not a valid line of a net
    NetSyntax = "net-syntax",
    /// The facts name a base unit for which the table has no times
    NoBase = "no-base",
    /// An instruction joins two blocks of contacts, but fewer blocks come before it
    NoBlock = "no-block",
    /// A branch is read or closed but was not opened
    NoBranch = "no-branch",
    /// `--clock` does not apply to this CPU, or contradicts a stated time
    NoClock = "no-clock",
    /// An instruction that needs a condition has none
    NoCondition = "no-condition",
    /// A response time needs the delay of inputs or outputs, which is not known
    NoDelay = "no-delay",
    /// An instruction lacks the device that it needs
    NoDevice = "no-device",
    /// A routine, a group or a file has nothing that ends it
    NoEnd = "no-end",
    /// A program starts or stops a group that does not exist
    NoGroup = "no-group",
    /// An export has no column headings
    NoHeads = "no-heads",
    /// A file contains no instruction
    NoInstructions = "no-instructions",
    /// The facts state how often an interrupt routine runs that the program does not have
    NoInterrupt = "no-interrupt",
    /// A jump or call goes to a label that does not exist
    NoLabel = "no-label",
    /// NEXT or BREAK stands outside of a loop
    NoLoop = "no-loop",
    /// A flowchart has no main routine
    NoMain = "no-main",
    /// A master control region is closed but was not opened
    NoMasterControl = "no-master-control",
    /// An instruction lacks an operand that it needs
    NoOperand = "no-operand",
    /// No program was given
    NoProgram = "no-program",
    /// No response time is known for the program
    NoResponse = "no-response",
    /// A subroutine or an interrupt program has no return instruction
    NoReturn = "no-return",
    /// A return instruction is not in a subroutine
    NoRoutine = "no-routine",
    /// An instruction has no rung before it
    NoRung = "no-rung",
    /// A call names a subroutine that does not exist
    NoSubroutine = "no-subroutine",
    /// `--dialect` names no known dialect
    NoSuchDialect = "no-such-dialect",
    /// A line of a table of symbols cannot be read, or contradicts a line before it
    NoSymbol = "no-symbol",
    /// There is no timing table for the CPU, or the CPU is not known
    NoTable = "no-table",
    /// An instruction has no time in the table, or the times add up to too much
    NoTime = "no-time",
    /// A line is not an instruction
    NotAnInstruction = "not-an-instruction",
    /// An instruction, or a way of running programs, is not modelled
    NotModelled = "not-modelled",
    /// A chart cannot be rewritten with explicit parallel sequences
    NotRewritten = "not-rewritten",
    /// A file contains what looks like a program, but its name is not a program's
    OddName = "odd-name",
    /// A branch is not closed in its rung
    OpenBranch = "open-branch",
    /// A loop has no end
    OpenLoop = "open-loop",
    /// A master control region has no end
    OpenMasterControl = "open-master-control",
    /// A quotation mark is never closed
    OpenQuote = "open-quote",
    /// A rung ends without a coil or an instruction
    OpenRung = "open-rung",
    /// A string has no closing quotation mark
    OpenString = "open-string",
    /// An operand is of a kind that its instruction does not take
    Operand = "operand",
    /// An instruction has too few operands, or too many
    OperandCount = "operand-count",
    /// An instruction has too few or too many operands
    Operands = "operands",
    /// The files are for different CPUs, for a CPU of another series than the named one, or for an unsupported CPU
    OtherCpu = "other-cpu",
    /// A file is not in the dialect that the user named
    OtherDialect = "other-dialect",
    /// The bits that are written for a word do not match its instruction
    OtherPattern = "other-pattern",
    /// A group starts or stops itself
    OwnGroup = "own-group",
    /// The CPU may serve peripherals in parallel with the program
    Parallel = "parallel",
    /// A pragma may change what runs, or contains code whose time is not known
    Pragma = "pragma",
    /// A subroutine calls itself, directly or through others
    Recursion = "recursion",
    /// Two program files of the project hold the same text
    SameContent = "same-content",
    /// The analysis cannot follow a scan to its end
    Scan = "scan",
    /// The text in the place of a step number is not a number
    StepNumber = "step-number",
    /// A step number or an address does not follow from the one before it
    StepOrder = "step-order",
    /// The file of an emulation's inputs cannot be read
    Stimulus = "stimulus",
    /// A column of an emulation's inputs names no input
    StimulusColumn = "stimulus-column",
    /// A row of an emulation's inputs does not match its heading
    StimulusRow = "stimulus-row",
    /// The time limit or the user ended the audit before the source was read
    Stopped = "stopped",
    /// An instruction writes to an input
    StoreToInput = "store-to-input",
    /// A row has an operand but there is no instruction above it
    StrayOperand = "stray-operand",
    /// A text does not follow the syntax of its language
    Syntax = "syntax",
    /// A symbol has two addresses
    SymbolTwice = "symbol-twice",
    /// A timing table is based on a table that does not exist
    TableBase = "table-base",
    /// A column of a timing table is missing, appears twice, or is not known
    TableColumn = "table-column",
    /// A timing table has two rows with one name
    TableDuplicate = "table-duplicate",
    /// A timing table has no rows
    TableEmpty = "table-empty",
    /// A timing table is not text in UTF-8
    TableEncoding = "table-encoding",
    /// A timing table has an unknown kind of evidence
    TableEvidence = "table-evidence",
    /// A timing table has more errors than are listed
    TableFaults = "table-faults",
    /// A number of points in a timing table cannot be read
    TablePoints = "table-points",
    /// A row of a timing table does not match its heading
    TableRow = "table-row",
    /// A time or a factor in a timing table cannot be read
    TableTime = "table-time",
    /// The time limit ended the search before it found a scan that satisfies the facts
    Time = "time",
    /// The time of a timer stands without a timer before it
    TimeAlone = "time-alone",
    /// A file is larger than any program
    TooLarge = "too-large",
    /// A program is longer than the memory of the PLC
    TooLong = "too-long",
    /// A project has more instructions than any CPU holds
    TooMany = "too-many",
    /// A flowchart has more groups than allowed
    TooManyGroups = "too-many-groups",
    /// A subroutine is defined twice
    Twice = "twice",
    /// A file is a valid program in two dialects
    TwoDialects = "two-dialects",
    /// Two programs were given for a PC that runs one
    TwoPrograms = "two-programs",
    /// Blocks of contacts are not joined
    Unjoined = "unjoined",
    /// The PLC does not have a device of this name or number
    UnknownDevice = "unknown-device",
    /// A file is not a program in a known dialect
    UnknownDialect = "unknown-dialect",
    /// An instruction is not known
    UnknownInstruction = "unknown-instruction",
    /// A name is not defined
    UnknownName = "unknown-name",
    /// A type is not known
    UnknownType = "unknown-type",
    /// A memory contains bytes that the program counter cannot reach
    Unreachable = "unreachable",
    /// A file cannot be read
    Unreadable = "unreadable",
    /// A file has a tool's own format that is not supported
    UnsupportedFormat = "unsupported-format",
    /// A condition is computed, but no instruction uses it
    UnusedCondition = "unused-condition",
    /// A fact has no effect on this program
    UnusedFact = "unused-fact",
    /// A pattern of `--ignore` matches no file
    UnusedIgnore = "unused-ignore",
    /// No instruction, or not every instruction of this name, uses a stated time
    UnusedTime = "unused-time",
    /// A word of the program memory is given twice
    WordTwice = "word-twice",
    /// The end of a group stands in another group, or in none
    WrongEnd = "wrong-end",
    /// A file is not well-formed XML, or not the XML that it claims to be
    Xml = "xml",
}
