#![doc = include_str!("ARCHITECTURE.md")]

pub mod lightmap;
pub mod math;

pub mod scene;

pub mod trace;

pub mod student;

pub mod transport;

pub mod solver;

pub mod render;

pub mod check;

pub mod files;

pub mod course;

#[cfg(feature = "gpu")]
pub mod gpu;

#[cfg(feature = "app")]
pub mod app;

pub mod cli;
