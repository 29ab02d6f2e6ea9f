//! Timers, runs from power-up and real scans.
