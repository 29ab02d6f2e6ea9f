//! Names, calls and initial values of IEC 61131-3 programs.
