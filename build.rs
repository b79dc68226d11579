//! What `biprism --version` says of the build: target, profile, compiler.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let told = |name: &str| env::var(name).unwrap_or_else(|_| "unknown".to_owned());
    for name in ["TARGET", "PROFILE", "OPT_LEVEL"] {
        println!("cargo:rustc-env=BIPRISM_{name}={}", told(name));
    }
    let compiler = Command::new(told("RUSTC")).arg("--version").output().ok();
    let compiler = compiler.and_then(|output| String::from_utf8(output.stdout).ok());
    println!("cargo:rustc-env=BIPRISM_RUSTC={}", compiler.as_deref().unwrap_or("unknown").trim());
}
