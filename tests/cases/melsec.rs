//! MELSEC and OMRON lists: operands, operation errors, damaged files, and what trust is worth.
