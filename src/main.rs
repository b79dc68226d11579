//! The command `biprism`.

fn main() {}
