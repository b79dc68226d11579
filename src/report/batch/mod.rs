//! Results of many jobs: a line a job, and charts of them.

pub mod job_line;
pub mod flat;
pub mod sweep_chart;
