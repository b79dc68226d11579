//! Studies of an instrument: each a function of values. None touches files, and only [`cost`] reads the clock.

pub mod budget;
pub mod compare;
pub mod fates;
pub mod cost;
pub mod cutter;
pub mod judge;
pub mod listed_corners;
pub mod stability;
pub mod truth;
pub mod view;
pub mod board_indexing;
pub mod corners_on_board;
pub mod half_image;
pub mod not_judged_cause;
pub mod not_judged;
pub mod photograph;
pub mod estimate;
pub mod fit_shift;
pub mod transfer_choice;
pub mod relay;
pub mod convergence;
pub mod reprojection_study;
pub mod layout;
pub mod stereo_truth;
