//! Studies of an instrument: each a function of values. None touches files, and only [`cost`] reads the clock.

pub mod anchor;
pub mod budget;
pub mod cost;
pub mod forecast;
pub mod judge;
pub mod nominal;
pub mod stability;
pub mod truth;
pub mod view;
pub mod record;
