//! Which kind of finding it is: short names that stay the same whatever the words around them, so that a pipeline can
//! hold on to them. `docs/codes` has a page for each.

use std::fmt;

/// Makes the codes from one list: a line on what each means, and its name.
macro_rules! codes {
    ($(#[doc = $summary:literal] $code:ident = $name:literal,)*) => {
        /// The code of a finding.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code {
            $(#[doc = $summary] $code,)*
        }

        impl Code {
            /// All codes, in the order of their names.
            pub const ALL: &[Code] = &[$(Code::$code,)*];

            /// Its name, as reports have it.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Code::$code => $name,)*
                }
            }

            /// Its page: what it means, an example, what to do.
            #[must_use]
            pub const fn page(self) -> &'static str {
                match self {
                    $(Code::$code => include_str!(concat!("../../docs/codes/", $name, ".md")),)*
                }
            }

            /// What it means, in one line.
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
    /// An address, or a label, has no instruction behind it
    BareAddress = "bare-address",
    /// A step number has no instruction behind it
    BareStep = "bare-step",
    /// Instructions stand where the PLC does not run them: behind a subroutine
    BehindSubroutine = "behind-subroutine",
    /// A record stands behind the end of an Intel HEX file
    BehindTheEnd = "behind-the-end",
    /// A file is binary data, or a tool's own file
    BinaryFile = "binary-file",
    /// A rung joins branches that are not open, or leaves open ones
    Branches = "branches",
    /// A project file ends too soon, or holds no program
    BrokenProject = "broken-project",
    /// A file of measurements cannot be read as one
    Capture = "capture",
    /// A sequential function chart does not hang together
    Chart = "chart",
    /// A row's columns are not those of the table's heads
    Columns = "columns",
    /// Only device comments were given, and no program
    CommentsAlone = "comments-alone",
    /// A connection of a drawing leads nowhere, or round in a circle
    Connection = "connection",
    /// A loop and a master control region cut across each other
    CrossedMasterControl = "crossed-master-control",
    /// A label stands at two places
    DoubleLabel = "double-label",
    /// A file holds nothing
    EmptyFile = "empty-file",
    /// A program of the project has no instructions
    EmptyProgram = "empty-program",
    /// A file is no text in the encoding that it seems to have
    Encoding = "encoding",
    /// An instruction has an operand too many
    ExtraOperand = "extra-operand",
    /// A scan ends outside of what is stated to hold whenever one starts
    BrokenFact = "broken-fact",
    /// A stated fact does not fit the program or the machine
    Fact = "fact",
    /// The facts file cannot be taken, or no scan keeps what it states
    Facts = "facts",
    /// An instruction's name and its function number disagree
    FunctionNumber = "function-number",
    /// A group's number is out of range
    GroupNumber = "group-number",
    /// Two groups have the same number
    GroupTwice = "group-twice",
    /// A line is no Intel HEX record that has a meaning here
    HexRecord = "hex-record",
    /// The main routine can stay in an inner loop, each iteration of which counts as a pass
    InnerLoop = "inner-loop",
    /// An interlock's begin and end do not fit together
    Interlock = "interlock",
    /// A jump and its end do not fit together, or it goes back
    Jump = "jump",
    /// A jump goes into or out of a master control region
    JumpAcrossMasterControl = "jump-across-master-control",
    /// A jump goes back, so nothing bounds the scan
    JumpBack = "jump-back",
    /// GJ stands where it has no known meaning
    JumpInGroup = "jump-in-group",
    /// A jump goes into a loop of FOR and NEXT
    JumpIntoLoop = "jump-into-loop",
    /// A jump goes to another routine
    JumpOut = "jump-out",
    /// A label stands at two places of a flowchart
    LabelTwice = "label-twice",
    /// A file was left out that may belong to the scan
    LeftOut = "left-out",
    /// A line is far longer than an instruction
    LongLine = "long-line",
    /// A loop's begin and end do not fit together, or it makes too many iterations
    Loop = "loop",
    /// A loop's count is no number, or out of range
    LoopCount = "loop-count",
    /// A timer is asked for together with other tests
    MixedCondition = "mixed-condition",
    /// Files of two dialects were given as one project
    MixedDialects = "mixed-dialects",
    /// A file has more errors than are listed
    MoreErrors = "more-errors",
    /// A file has more warnings than are listed
    MoreWarnings = "more-warnings",
    /// Nothing says in which order the programs run
    NameOrder = "name-order",
    /// A file was named twice
    NamedTwice = "named-twice",
    /// A directory within a directory was not read
    NestedDirectory = "nested-directory",
    /// Calls or loops stand in each other too deep
    Nesting = "nesting",
    /// An address of a net is missing, given twice, or of the wrong kind
    NetAddress = "net-address",
    /// An arc or gate of a net joins what cannot be joined
    NetArc = "net-arc",
    /// An element of a net has no arcs, or more than it may have
    NetElement = "net-element",
    /// A name of a net stands for nothing, or for two elements
    NetName = "net-name",
    /// A line is not written as a line of a net
    NetSyntax = "net-syntax",
    /// The facts name a base unit of which the table has no times
    NoBase = "no-base",
    /// An instruction joins two blocks of contacts where there are fewer
    NoBlock = "no-block",
    /// A branch is read or closed that was not opened
    NoBranch = "no-branch",
    /// `--clock` says nothing here, or contradicts a time
    NoClock = "no-clock",
    /// An instruction that asks for a condition has none
    NoCondition = "no-condition",
    /// No delay of inputs or outputs is known, which a response time needs
    NoDelay = "no-delay",
    /// An instruction has no device
    NoDevice = "no-device",
    /// A routine, a group or a file has no end
    NoEnd = "no-end",
    /// A group is started or stopped that does not exist
    NoGroup = "no-group",
    /// An export has no column heads
    NoHeads = "no-heads",
    /// A file holds no instruction
    NoInstructions = "no-instructions",
    /// It is stated how often an interrupt routine runs that does not exist
    NoInterrupt = "no-interrupt",
    /// A jump or call goes to a label that does not exist
    NoLabel = "no-label",
    /// NEXT or BREAK stands outside of a loop
    NoLoop = "no-loop",
    /// A flowchart has no main routine
    NoMain = "no-main",
    /// A master control region is closed that was not opened
    NoMasterControl = "no-master-control",
    /// An instruction has no operand
    NoOperand = "no-operand",
    /// No program was given
    NoProgram = "no-program",
    /// No response time is known for the program
    NoResponse = "no-response",
    /// A subroutine or an interrupt program has no end
    NoReturn = "no-return",
    /// A return ends no subroutine
    NoRoutine = "no-routine",
    /// An instruction has no rung in front of it
    NoRung = "no-rung",
    /// A subroutine is called that does not exist
    NoSubroutine = "no-subroutine",
    /// `--dialect` names no known dialect
    NoSuchDialect = "no-such-dialect",
    /// A line of a table of symbols cannot be read, or contradicts another
    NoSymbol = "no-symbol",
    /// There is no timing table for the CPU, or the CPU is not known
    NoTable = "no-table",
    /// An instruction has no time in the table, or the times do not add up
    NoTime = "no-time",
    /// A line is no instruction
    NotAnInstruction = "not-an-instruction",
    /// An instruction, or a way to run programs, has no model here
    NotModelled = "not-modelled",
    /// A chart cannot be rewritten with explicit parallel sequences
    NotRewritten = "not-rewritten",
    /// A file reads like a program but has no program's name
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
    /// The instruction does not take this operand
    Operand = "operand",
    /// An instruction has too few operands, or too many
    OperandCount = "operand-count",
    /// An instruction's operands do not fit its name
    Operands = "operands",
    /// The files are for different CPUs, for another than is named, or for one that has no bound
    OtherCpu = "other-cpu",
    /// A file is in another dialect than was named
    OtherDialect = "other-dialect",
    /// A word's bits are not those of its instruction
    OtherPattern = "other-pattern",
    /// A group starts or stops itself
    OwnGroup = "own-group",
    /// The CPU may serve peripherals beside the program
    Parallel = "parallel",
    /// A subroutine calls itself, directly or through others
    Recursion = "recursion",
    /// The scan cannot be followed
    Scan = "scan",
    /// A step number is no number
    StepNumber = "step-number",
    /// A step number is not larger than the one before
    StepOrder = "step-order",
    /// The file of an emulation's inputs cannot be read
    Stimulus = "stimulus",
    /// A column of an emulation's inputs names no input
    StimulusColumn = "stimulus-column",
    /// A row of an emulation's inputs does not fit its heads
    StimulusRow = "stimulus-row",
    /// An instruction writes to an input
    StoreToInput = "store-to-input",
    /// A row has an operand and there is no instruction above it
    StrayOperand = "stray-operand",
    /// A text does not follow the syntax of its language
    Syntax = "syntax",
    /// A symbol stands for two addresses
    SymbolTwice = "symbol-twice",
    /// A timing table amends a table that does not exist
    TableBase = "table-base",
    /// A column of a timing table is missing, twice there, or not known
    TableColumn = "table-column",
    /// A timing table has two rows of one name
    TableDuplicate = "table-duplicate",
    /// A timing table has no rows
    TableEmpty = "table-empty",
    /// A timing table is no text in UTF-8
    TableEncoding = "table-encoding",
    /// A timing table has an unknown kind of evidence
    TableEvidence = "table-evidence",
    /// A timing table has more faults than are listed
    TableFaults = "table-faults",
    /// A number of points in a timing table cannot be read
    TablePoints = "table-points",
    /// A row of a timing table does not fit its heads
    TableRow = "table-row",
    /// A time or a factor in a timing table cannot be read
    TableTime = "table-time",
    /// The time limit ended the search before a scan was found that keeps what is stated
    Time = "time",
    /// A time has no timer in front of it
    TimeAlone = "time-alone",
    /// A file is larger than any program
    TooLarge = "too-large",
    /// A program is longer than the machine's memory
    TooLong = "too-long",
    /// A project has more instructions than any CPU holds
    TooMany = "too-many",
    /// A flowchart has more groups than there can be
    TooManyGroups = "too-many-groups",
    /// A subroutine is defined twice
    Twice = "twice",
    /// A file reads as a program in two dialects
    TwoDialects = "two-dialects",
    /// Two programs were given to a PC that runs one
    TwoPrograms = "two-programs",
    /// Blocks of contacts are not joined
    Unjoined = "unjoined",
    /// The machine does not have such a device
    UnknownDevice = "unknown-device",
    /// A file is no program in a known dialect
    UnknownDialect = "unknown-dialect",
    /// An instruction is not known
    UnknownInstruction = "unknown-instruction",
    /// A name stands for nothing
    UnknownName = "unknown-name",
    /// A type is not known
    UnknownType = "unknown-type",
    /// Bytes stand in a memory where the program never gets
    Unreachable = "unreachable",
    /// A file cannot be read
    Unreadable = "unreadable",
    /// A file is a tool's own format that is not read
    UnsupportedFormat = "unsupported-format",
    /// A condition decides nothing
    UnusedCondition = "unused-condition",
    /// A fact says nothing of this program
    UnusedFact = "unused-fact",
    /// A pattern of `--ignore` leaves nothing out
    UnusedIgnore = "unused-ignore",
    /// A stated time is used by no instruction, or not by all of its name
    UnusedTime = "unused-time",
    /// A word of the program memory is given twice
    WordTwice = "word-twice",
    /// A group's end stands in another group, or in none
    WrongEnd = "wrong-end",
    /// A file is no well-formed XML, or not the XML that it claims to be
    Xml = "xml",
}
