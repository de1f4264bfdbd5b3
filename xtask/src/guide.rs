//! `cargo xtask guide`: runs the commands that make the pictures of the guide.

use std::fs;

use crate::command::{Result, fairform, root, step};

/// One command per line, run in the folder of the guide; `#` begins a comment.
const LIST: &str = "docs/guide/pictures.txt";

pub(crate) fn run() -> Result {
    let place = root().join("docs/guide");
    let list = match fs::read_to_string(root().join(LIST)) {
        Ok(list) => list,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            eprintln!("nothing to do: there is no {LIST}");
            return Ok(());
        }
        Err(e) => return Err(format!("{LIST}: {e}")),
    };
    for (i, line) in list.lines().enumerate() {
        let words = words(line).map_err(|why| format!("{LIST}, line {}: {why}", i + 1))?;
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        match words.as_slice() {
            [] => {}
            ["fairform", args @ ..] => step(line, &mut fairform("release", &place, args))?,
            [other, ..] => {
                return Err(format!("{LIST}, line {}: {other} is not fairform", i + 1));
            }
        }
    }
    Ok(())
}

/// The words of a command line, up to a comment; quotes of either kind keep spaces.
fn words(line: &str) -> Result<Vec<String>> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for c in line.chars() {
        match (quote, c) {
            (Some(q), _) if c == q => quote = None,
            (None, '"' | '\'') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, '#') if word.is_none() => break,
            (None, _) if c.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(c),
        }
    }
    if quote.is_some() {
        return Err("a quote is not closed".into());
    }
    words.extend(word);
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn words_are_those_of_a_shell() {
        let line = "fairform render 'a b.obj' --title \"it's # one\"  # a comment";
        let expected = ["fairform", "render", "a b.obj", "--title", "it's # one"];
        assert_eq!(words(line).unwrap(), expected);
        assert_eq!(words("a#b ''").unwrap(), ["a#b", ""]);
        assert_eq!(words("  # nothing").unwrap(), [""; 0]);
        assert!(words("an open 'quote").is_err());
    }
}
