//! The text of an OBJ or MTL file: decoded, with continued lines joined and lines counted.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

/// The file's text without byte-order mark. Bytes that are not UTF-8 make the whole file Latin-1, as older programs
/// wrote it, so that different names stay different. A file with old Macintosh line ends gets new ones.
pub fn read(path: &Path) -> io::Result<String> {
    let bytes = std::fs::read(path)?;
    let text = String::from_utf8(bytes).unwrap_or_else(|e| e.as_bytes().iter().map(|&b| char::from(b)).collect());
    let text = match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    };
    Ok(if text.contains('\r') && !text.contains('\n') { text.replace('\r', "\n") } else { text })
}

/// A statement: its first line, one-based, its keyword and the rest of the line, trimmed.
pub struct Statement<'a> {
    pub line: u32,
    text: Cow<'a, str>,
    keyword_end: usize,
}

impl Statement<'_> {
    pub fn keyword(&self) -> &str {
        &self.text[..self.keyword_end]
    }

    /// Everything after the keyword: a name with its inner spaces.
    pub fn rest(&self) -> &str {
        self.text[self.keyword_end..].trim()
    }

    /// The blank-separated words after the keyword, up to a comment.
    pub fn words(&self) -> impl Iterator<Item = &str> {
        self.text[self.keyword_end..].split_ascii_whitespace().take_while(|w| !w.starts_with('#'))
    }
}

/// The statements of a text: no blank lines, no comments, lines that end in `\` joined with their successors.
pub fn statements(text: &str) -> impl Iterator<Item = Statement<'_>> {
    let mut lines = (1u32..).zip(text.lines());
    std::iter::from_fn(move || {
        loop {
            let (line, first) = lines.next()?;
            let first = first.trim();
            // A comment that ends in a backslash (a Windows path) does not swallow the next line.
            if first.is_empty() || first.starts_with('#') {
                continue;
            }
            let mut text = Cow::Borrowed(first);
            while text.ends_with('\\') {
                let joined = text.to_mut();
                joined.pop();
                joined.push(' ');
                joined.push_str(lines.next().map_or("", |(_, l)| l.trim()));
            }
            let keyword_end = text.find(char::is_whitespace).unwrap_or(text.len());
            return Some(Statement { line, text, keyword_end });
        }
    })
}

/// The existing file that `name`, written in a file of `folder`, means: as it stands, with `\` as a separator, or,
/// as files are moved without their folders, the last component beside the file that names it.
pub fn resolve(folder: &Path, name: &str) -> Option<PathBuf> {
    let slashed = name.replace('\\', "/");
    let last = slashed.rsplit('/').next().unwrap_or_default();
    [name, &slashed, last].into_iter().filter(|n| !n.is_empty()).map(|n| folder.join(n)).find(|p| p.is_file())
}

/// The folder of a file: where the names inside it start.
pub fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<(u32, String, String)> {
        statements(text).map(|s| (s.line, s.keyword().to_owned(), s.rest().to_owned())).collect()
    }

    #[test]
    fn joins_continued_lines_and_counts_all() {
        let text = "# c:\\\nv 1 \\\r\n 2 \\\n3\r\n\n\to  two  words \nf\\";
        let expected = [(2, "v", "1  2  3"), (6, "o", "two  words"), (7, "f", "")];
        assert_eq!(lines(text), expected.map(|(l, k, r)| (l, k.to_owned(), r.to_owned())));
    }

    #[test]
    fn words_end_at_a_comment() {
        let all = statements("Kd 1 2 3 # white").map(|s| s.words().collect::<Vec<_>>().join(",")).collect::<Vec<_>>();
        assert_eq!(all, ["1,2,3"]);
    }

    #[test]
    fn decodes_marks_latin_1_and_old_line_ends() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("a.obj");
        for (bytes, text) in [
            (&b"\xef\xbb\xbfo a"[..], "o a"),
            (b"o M\xf6bel\n", "o Möbel\n"),
            ("o Möbel\n".as_bytes(), "o Möbel\n"),
            (b"o a\rv 1\r", "o a\nv 1\n"),
        ] {
            std::fs::write(&path, bytes)?;
            assert_eq!(read(&path)?, text);
        }
        Ok(())
    }
}
