//! The page as a whole: templates, style and scripts, put together into one file.

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, Value};
use serde::Serialize;

/// The templates by name; every page but the shell fills the shell's blocks.
const TEMPLATES: [(&str, &str); 5] = [
    ("shell.html", include_str!("assets/shell.html")),
    ("origin.html", include_str!("assets/origin.html")),
    ("comparison.html", include_str!("assets/comparison.html")),
    ("study.html", include_str!("assets/study.html")),
    ("cost.html", include_str!("assets/cost.html")),
];

/// What is put into every page as it is.
const STYLE: [&str; 2] = [include_str!("assets/uplot.min.css"), include_str!("assets/page.css")];

/// The scripts that a page may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scripts {
    /// Words on hover alone.
    Words,
    /// And charts of costs.
    Cost,
    /// And charts and the viewer of pictures.
    Viewer,
}

impl Scripts {
    fn text(self) -> String {
        const UPLOT: &str = include_str!("assets/uplot.min.js");
        const WORDS: &str = include_str!("assets/words.js");
        const CHARTS: &str = include_str!("assets/charts.js");
        const VIEWER: [&str; 5] = [
            include_str!("assets/epipolar.js"),
            include_str!("assets/overlays.js"),
            include_str!("assets/viewer.js"),
            include_str!("assets/controls.js"),
            include_str!("assets/curves.js"),
        ];
        let parts: Vec<&str> = match self {
            Self::Words => vec![WORDS],
            Self::Cost => vec![UPLOT, WORDS, CHARTS, include_str!("assets/cost.js")],
            Self::Viewer => [UPLOT, WORDS, CHARTS].into_iter().chain(VIEWER).collect(),
        };
        parts.join("\n")
    }
}

/// The page of `template` with what `context` holds; `data` is JSON for the scripts.
///
/// # Panics
/// Where a template is wrong, which every page shows.
pub(super) fn page(template: &str, scripts: Scripts, data: &str, context: &impl Serialize) -> String {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build();
    environment.set_syntax(syntax.expect("blocks that are trimmed are no wrong syntax"));
    for (name, text) in TEMPLATES {
        environment.add_template(name, text).expect("the templates are well formed");
    }
    let trusted = |text: String| Value::from_safe_string(text);
    let whole = minijinja::context! {
        style => trusted(STYLE.join("\n")),
        script => trusted(scripts.text()),
        data => trusted(inert(data)),
        version => env!("CARGO_PKG_VERSION"),
        ..Value::from(Serde(context))
    };
    let template = environment.get_template(template).expect("there is such a template");
    template.render(whole).expect("the template fits what it is filled with")
}

/// JSON that no reader of HTML takes for markup.
fn inert(json: &str) -> String {
    json.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_and_words_cannot_end_their_element() {
        assert_eq!(inert("{\"a\":\"</script>\"}"), "{\"a\":\"\\u003c/script>\"}");
        let context = minijinja::context! { title => "a <b> & \"c\"", tables => Vec::<String>::new() };
        let text = page("study.html", Scripts::Words, "null", &context);
        assert!(text.contains("<title>a &lt;b&gt; &amp; &quot;c&quot;</title>") && !text.contains("<b>"), "{text}");
    }
}
