//! Text between two marks in a Markdown file.

/// The text between `<!-- name:begin -->` and `<!-- name:end -->`.
pub struct Marks<'a>(pub &'a str);

impl Marks<'_> {
    /// Returns the two marks.
    pub fn pair(&self) -> [String; 2] {
        ["begin", "end"].map(|which| format!("<!-- {}:{which} -->", self.0))
    }

    /// Returns the file's text with that between the marks replaced by `content`; none where a mark is missing.
    pub fn replaced(&self, text: &str, content: &str) -> Option<String> {
        let [begin, end] = self.pair();
        let (before, rest) = text.split_once(&begin)?;
        let (_, after) = rest.split_once(&end)?;
        Some(format!("{before}{begin}\n{content}\n{end}{after}"))
    }
}
