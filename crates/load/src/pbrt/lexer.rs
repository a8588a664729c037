//! Bytes to tokens.
//!
//! The lexer sees no numbers: a bare word is a number only where one is expected, and the parser then reads it from the
//! text without a token in between.

use sahl_scene::{FileId, Span};

use super::number::{ends_token, token_length};

/// A token, told by its kind and its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Token {
    pub(super) kind: TokenKind,
    pub(super) start: u32,
    pub(super) end: u32,
}

/// The kinds of token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TokenKind {
    /// A directive, a number, `true` or `false`.
    Word,
    /// A string with its quotes.
    Quoted,
    /// A string that the line ends before its second quote.
    Unterminated,
    /// `[`
    Open,
    /// `]`
    Close,
    /// The end of the file.
    End,
}

/// A place in the text of one file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lexer<'t> {
    text: &'t [u8],
    file: FileId,
    at: usize,
}

impl<'t> Lexer<'t> {
    /// Starts at byte `at` of `text`, which is shorter than 2³² bytes.
    pub(super) fn new(text: &'t [u8], file: FileId, at: usize) -> Self {
        Self { text, file, at: at.min(text.len()) }
    }

    /// The offset of the next byte.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// Continues at byte `at`.
    pub(super) fn seek(&mut self, at: u32) {
        self.at = at as usize;
    }

    /// The span of `token`.
    pub(super) fn span(&self, token: Token) -> Span {
        Span { file: self.file, start: token.start, end: token.end }
    }

    /// The text of `token`.
    pub(super) fn bytes(&self, token: Token) -> &'t [u8] {
        &self.text[token.start as usize..token.end as usize]
    }

    /// What follows, white space and comments skipped.
    #[inline]
    pub(super) fn rest(&mut self) -> &'t [u8] {
        self.skip_blank();
        &self.text[self.at..]
    }

    /// Skips `length` bytes and returns the token that they are.
    #[inline]
    pub(super) fn take(&mut self, length: usize) -> Token {
        let start = self.at;
        self.at = (start + length).min(self.text.len());
        self.token(TokenKind::Word, start)
    }

    /// The next token.
    pub(super) fn next(&mut self) -> Token {
        self.skip_blank();
        let start = self.at;
        let kind = match self.text.get(start) {
            None => TokenKind::End,
            Some(b'[') => {
                self.at += 1;
                TokenKind::Open
            }
            Some(b']') => {
                self.at += 1;
                TokenKind::Close
            }
            Some(b'"') => self.quoted(),
            Some(_) => {
                self.at += token_length(&self.text[start..]).max(1);
                TokenKind::Word
            }
        };
        self.token(kind, start)
    }

    /// The next token, without moving on.
    pub(super) fn peek(&self) -> Token {
        Lexer { ..*self }.next()
    }

    fn token(&self, kind: TokenKind, start: usize) -> Token {
        Token { kind, start: start as u32, end: self.at as u32 }
    }

    /// Skips a string from its first quote; a line break ends one that is not closed.
    fn quoted(&mut self) -> TokenKind {
        self.at += 1;
        while let Some(&byte) = self.text.get(self.at) {
            match byte {
                b'"' => {
                    self.at += 1;
                    return TokenKind::Quoted;
                }
                b'\n' => break,
                b'\\' => self.at = (self.at + 2).min(self.text.len()),
                _ => self.at += 1,
            }
        }
        TokenKind::Unterminated
    }

    #[inline]
    fn skip_blank(&mut self) {
        while let Some(&byte) = self.text.get(self.at) {
            match byte {
                b'#' => {
                    let comment = &self.text[self.at..];
                    self.at += comment.iter().position(|&byte| byte == b'\n').unwrap_or(comment.len());
                }
                b'"' | b'[' | b']' => break,
                byte if ends_token(byte) => self.at += 1,
                _ => break,
            }
        }
    }
}

/// The contents of a string token, its escapes resolved; bytes that are not UTF-8 are replaced.
pub(super) fn unquote(token: &[u8]) -> String {
    let inner = token.strip_prefix(b"\"").unwrap_or(token);
    let inner = inner.strip_suffix(b"\"").unwrap_or(inner);
    if !inner.contains(&b'\\') {
        return String::from_utf8_lossy(inner).into_owned();
    }
    let mut bytes = inner.iter().copied();
    let mut resolved = Vec::with_capacity(inner.len());
    while let Some(byte) = bytes.next() {
        resolved.push(if byte == b'\\' { escape(bytes.next()) } else { byte });
    }
    String::from_utf8_lossy(&resolved).into_owned()
}

/// What a backslash before `byte` stands for.
fn escape(byte: Option<u8>) -> u8 {
    match byte {
        Some(b'b') => 0x08,
        Some(b'f') => 0x0c,
        Some(b'n') => b'\n',
        Some(b'r') => b'\r',
        Some(b't') => b'\t',
        Some(other) => other,
        None => b'\\',
    }
}

#[cfg(test)]
mod tests {
    use sahl_scene::Sources;

    use super::*;

    fn tokens(text: &str) -> Vec<(TokenKind, String)> {
        let file = Sources::default().add("test", text.as_bytes());
        let mut lexer = Lexer::new(text.as_bytes(), file, 0);
        let mut found = Vec::new();
        loop {
            let token = lexer.next();
            if token.kind == TokenKind::End {
                return found;
            }
            found.push((token.kind, String::from_utf8_lossy(lexer.bytes(token)).into_owned()));
        }
    }

    #[test]
    fn words_strings_and_brackets_need_no_space_between() {
        use TokenKind::*;
        let expected =
            [(Word, "Shape"), (Quoted, "\"a b\""), (Open, "["), (Word, "1"), (Close, "]"), (Word, "x")];
        let expected: Vec<_> = expected.map(|(kind, text)| (kind, text.to_owned())).into();
        assert_eq!(tokens("Shape\"a b\"[1]x # \"comment\" [ \n"), expected);
    }

    #[test]
    fn an_open_string_ends_with_its_line() {
        let found = tokens("\"abc\nShape");
        assert_eq!(found[0].0, TokenKind::Unterminated);
        assert_eq!(found[1], (TokenKind::Word, "Shape".to_owned()));
        assert_eq!(tokens("\"abc\\").len(), 1);
    }

    #[test]
    fn escapes_are_resolved() {
        assert_eq!(unquote(br#""a\"b\\c\n""#), "a\"b\\c\n");
        assert_eq!(unquote(br#""tex/a.png""#), "tex/a.png");
    }
}
