//! Studies of an instrument: each a function of values, none of which touches files or the clock.

pub mod anchor;
pub mod judge;
pub mod nominal;
pub mod stability;
pub mod truth;
pub mod view;
pub mod record;
