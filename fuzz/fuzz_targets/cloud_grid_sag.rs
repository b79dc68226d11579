#![no_main]

#[path = "../../tests/hostile/bodies.rs"]
#[allow(dead_code, reason = "each target uses one body")]
mod bodies;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| bodies::cloud(bytes, biprism::io::point_cloud::PointFormat::GridSag));
