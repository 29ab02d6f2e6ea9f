//! Reports, commands and their figures.
