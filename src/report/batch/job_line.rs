//! The line of a job.

use crate::error::Error;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Name and version of the form of a line.
pub const BATCH_SCHEMA: &str = "biprism-batch/1";

/// What became of a job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct JobLine {
    /// Where it belongs.
    #[serde(flatten)]
    pub head: JobHead,
    /// Name of the scene, where it could be read.
    pub scene: Option<String>,
    /// The keys that were changed, with their values.
    pub set: Map<String, Value>,
    /// Its figures by their paths, `null` where there is none; absent where it ended in an error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub figures: Option<Map<String, Value>>,
    /// What was asked for and is not kept, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unmet: Vec<String>,
    /// What was wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<JobError>,
    /// Seconds of wall-clock time.
    pub seconds: f64,
}

/// Where a job belongs: the beginning of its line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct JobHead {
    /// [`BATCH_SCHEMA`].
    pub schema: String,
    /// What tells the run from others: of the verb with its options, the scenes and all jobs.
    pub run: String,
    /// What is done with each scene.
    pub verb: String,
    /// Its number, from 0.
    pub job: u32,
    /// How many jobs the run has.
    pub jobs: u32,
    /// What tells the job from others of any run: its own word, or of verb, scene and changed keys.
    pub id: String,
}

/// An error as data.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct JobError {
    /// Where: a file, or how a value was given.
    pub place: String,
    /// The line in the file, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<usize>,
    /// The character in the line, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
    /// The key of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub key: Option<String>,
    /// What was found and which rule it breaks.
    pub rule: String,
    /// What to do next.
    pub help: String,
}

impl From<&Error> for JobError {
    fn from(error: &Error) -> Self {
        let Error { place, key, rule, help, .. } = error.clone();
        Self { place, line: error.line(), column: error.column(), key, rule, help }
    }
}

impl JobHead {
    /// The first key whose values differ in two runs, so that they are not one; the job itself may differ.
    pub(crate) fn difference(&self, other: &Self) -> Option<&'static str> {
        let pairs = [
            ("schema", self.schema == other.schema),
            ("verb", self.verb == other.verb),
            ("jobs", self.jobs == other.jobs),
            ("run", self.run == other.run),
        ];
        pairs.into_iter().find(|(_, same)| !same).map(|(key, _)| key)
    }
}

impl JobLine {
    /// The line, with a line break.
    ///
    /// # Errors
    /// When it is no JSON, which no line is.
    pub(crate) fn text(&self) -> Result<String, Error> {
        let text = serde_json::to_string(self);
        text.map(|text| text + "\n").map_err(|error| {
            Error::new(format!("job {}", self.head.job), format!("its line is no JSON: {error}"), "report it")
        })
    }

    /// Whether both say the same of the same job, whatever time it took.
    pub(crate) fn says_the_same(&self, other: &Self) -> bool {
        Self { seconds: 0.0, ..self.clone() } == Self { seconds: 0.0, ..other.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_line_reads_back() {
        let head = JobHead {
            schema: BATCH_SCHEMA.to_owned(),
            run: "r".to_owned(),
            verb: "compare".to_owned(),
            job: 3,
            jobs: 7,
            id: "i".to_owned(),
        };
        let error = Error::new("a.toml", "it is so", "do that").at("x\ny = 1\n", 6..7).of_key("y");
        let Value::Object(set) = json!({ "prism.index": 1.468 }) else { panic!("no table") };
        let line = JobLine {
            head,
            scene: Some("a".to_owned()),
            set: set.clone(),
            figures: None,
            unmet: Vec::new(),
            error: Some(JobError::from(&error)),
            seconds: 0.25,
        };
        let text = line.text().unwrap();
        assert!(
            text.starts_with(
                "{\"schema\":\"biprism-batch/1\",\"run\":\"r\",\"verb\":\"compare\",\"job\":3,\"jobs\":7,"
            )
        );
        assert!(text.contains("\"line\":2,\"column\":5,\"key\":\"y\"") && text.ends_with("}\n"), "{text}");
        assert_eq!(serde_json::from_str::<JobLine>(&text).unwrap(), line);
        let done = JobLine { figures: Some(set), error: None, seconds: 1.0, ..line.clone() };
        assert!(!done.says_the_same(&line) && line.says_the_same(&JobLine { seconds: 9.0, ..line.clone() }));
        let other = JobHead { jobs: 8, ..line.head.clone() };
        assert_eq!((line.head.difference(&other), line.head.difference(&done.head)), (Some("jobs"), None));
    }
}
