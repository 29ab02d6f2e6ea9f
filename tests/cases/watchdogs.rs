//! Watchdogs, constant scans, addresses of lists, nets and emulated CPUs.
