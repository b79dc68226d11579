//! Does the eye measure what is there? Pictures with known corners; one file a question.

mod answers;
mod boards;
mod borders;
mod clean;
mod judge;
mod lenses;
mod marks;
mod motion;
mod noise;
mod photograph;
mod seeds;
mod twins;
mod world;
mod written;
