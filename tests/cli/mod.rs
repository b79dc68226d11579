//! Do the commands do what they say: exit codes, messages, files?

mod batch;
mod compare;
mod compare_scenes;
mod corners;
mod dataset;
mod help;
mod rectify;
mod render;
mod set;
mod stereo_study;
mod studies;
mod tolerance;
mod trace;
mod words;
