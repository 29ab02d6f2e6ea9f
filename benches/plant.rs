//! Writes a plant program for measurements: `cargo bench --bench plant -- STATIONS SEED DIRECTORY`.
#![allow(clippy::print_stderr)]

#[path = "common/plant.rs"]
mod plant;

use std::path::PathBuf;

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let [stations, seed, directory] = &arguments[..] else {
        eprintln!("usage: cargo bench --bench plant -- STATIONS SEED DIRECTORY");
        return;
    };
    let (Ok(stations), Ok(seed)) = (stations.parse(), seed.parse()) else {
        eprintln!("stations and seed are numbers");
        return;
    };
    let directory = PathBuf::from(directory);
    std::fs::create_dir_all(&directory).expect("the directory can be made");
    for (station, text) in plant::plant(stations, seed).iter().enumerate() {
        std::fs::write(directory.join(format!("station{station:03}.il")), text)
            .expect("the file can be written");
    }
}
