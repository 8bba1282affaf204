//! The `radiosity` program: arguments in, exit status out.

fn main() {}
