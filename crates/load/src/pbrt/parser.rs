//! Tokens to statements.
//!
//! After a syntax error the parser goes on at the next keyword of a directive, so that one mistake gives one message.

use sahl_scene::{Diagnostic, FileId, Span, suggest};

use super::lexer::{Lexer, Token, TokenKind, unquote};
use super::number::parse_f64;
use super::parameter_list;
use super::report::{Report, quote};
use super::statement::{Arguments, Name, RULES, Rule, Statement, rule};

/// A syntax error that has been reported: the statement is given up.
pub(super) struct Abandoned;

/// Reads statements from a text.
pub(super) struct Parser<'t> {
    pub(super) lexer: Lexer<'t>,
    pub(super) report: &'t Report,
}

impl<'t> Parser<'t> {
    /// Starts at byte `at` of `text`.
    pub(super) fn new(text: &'t [u8], file: FileId, at: usize, report: &'t Report) -> Self {
        Self { lexer: Lexer::new(text, file, at), report }
    }

    /// The offset of the next byte.
    pub(super) fn position(&self) -> usize {
        self.lexer.position()
    }

    /// The next statement that is well formed; `None` at the end of the text.
    pub(super) fn next_statement(&mut self) -> Option<Statement> {
        loop {
            let token = self.lexer.next();
            if token.kind == TokenKind::End {
                return None;
            }
            let statement = match (token.kind, rule(self.lexer.bytes(token))) {
                (TokenKind::Word, Some(rule)) => self.statement(rule, token),
                _ => {
                    self.not_a_directive(token);
                    Err(Abandoned)
                }
            };
            match statement {
                Ok(statement) => return Some(statement),
                Err(Abandoned) => self.recover(),
            }
        }
    }

    /// Reads what follows the keyword at `token`.
    fn statement(&mut self, rule: &'static Rule, token: Token) -> Result<Statement, Abandoned> {
        let span = self.lexer.span(token);
        let mut statement =
            Statement { rule, span, numbers: Vec::new(), names: Vec::new(), parameters: Vec::new() };
        match rule.arguments {
            Arguments::Numbers(count) => self.numbers(&mut statement, count)?,
            Arguments::Matrix => {
                self.expect(TokenKind::Open, "`[`", rule)?;
                self.numbers(&mut statement, 16)?;
                self.expect(TokenKind::Close, "`]` after sixteen numbers", rule)?;
            }
            Arguments::Names(least, most) => self.names(&mut statement, least, most)?,
            Arguments::Parameters(count) => {
                self.names(&mut statement, count, count)?;
                statement.parameters = parameter_list::parse(self)?;
            }
            Arguments::Value => {
                self.names(&mut statement, 1, 1)?;
                self.value(&mut statement)?;
            }
            Arguments::Word => {
                let word = self.expect(TokenKind::Word, "a word", rule)?;
                self.push_name(&mut statement, word);
            }
        }
        Ok(statement)
    }

    fn numbers(&mut self, statement: &mut Statement, count: usize) -> Result<(), Abandoned> {
        for index in 0..count {
            let Some((number, length)) = parse_f64(self.lexer.rest()) else {
                let token = self.lexer.peek();
                let expected = format!("{count} numbers");
                self.report.push(self.unexpected(token, &expected, statement.rule).with_note(format!(
                    "{index} of the {count} numbers of `{}` were read",
                    statement.rule.name
                )));
                return Err(Abandoned);
            };
            let token = self.lexer.take(length);
            if !number.is_finite() {
                let text = quote(self.lexer.bytes(token));
                let message = format!("{text} is not a finite number");
                self.report.error("non-finite-number", self.lexer.span(token), message);
                return Err(Abandoned);
            }
            statement.numbers.push(number);
        }
        Ok(())
    }

    fn names(&mut self, statement: &mut Statement, least: usize, most: usize) -> Result<(), Abandoned> {
        for index in 0..most {
            if index >= least && self.lexer.peek().kind != TokenKind::Quoted {
                break;
            }
            let token = self.expect(TokenKind::Quoted, "a name in quotes", statement.rule)?;
            self.push_name(statement, token);
        }
        Ok(())
    }

    /// Reads the value of an option: a string, or a word.
    fn value(&mut self, statement: &mut Statement) -> Result<(), Abandoned> {
        let token = self.lexer.peek();
        if !matches!(token.kind, TokenKind::Quoted | TokenKind::Word) || self.is_keyword(token) {
            self.report.push(self.unexpected(token, "a value", statement.rule));
            return Err(Abandoned);
        }
        self.lexer.next();
        self.push_name(statement, token);
        Ok(())
    }

    fn push_name(&self, statement: &mut Statement, token: Token) {
        let span = self.lexer.span(token);
        statement.names.push(Name { text: unquote(self.lexer.bytes(token)), span });
        statement.span = statement.span.to(span);
    }

    /// Takes the next token if it is of this kind.
    fn expect(&mut self, kind: TokenKind, expected: &str, rule: &Rule) -> Result<Token, Abandoned> {
        let token = self.lexer.peek();
        if token.kind == kind {
            return Ok(self.lexer.next());
        }
        self.report.push(self.unexpected(token, expected, rule));
        Err(Abandoned)
    }

    /// The message that `token` stands where something else is expected.
    fn unexpected(&self, token: Token, expected: &str, rule: &Rule) -> Diagnostic {
        let found = self.describe(token);
        let message = format!("`{}` expects {expected}, found {found}", rule.name);
        self.syntax_error(token, message)
    }

    /// An error about `token`: one that names the open string if that is what it is.
    pub(super) fn syntax_error(&self, token: Token, message: String) -> Diagnostic {
        let span = self.lexer.span(token);
        match token.kind {
            TokenKind::Unterminated => unterminated(span),
            _ => Diagnostic::error("syntax", span, message),
        }
    }

    /// What a message calls `token`.
    pub(super) fn describe(&self, token: Token) -> String {
        match token.kind {
            TokenKind::End => "the end of the file".to_owned(),
            TokenKind::Quoted => format!("the string {}", quote(self.lexer.bytes(token))),
            _ => quote(self.lexer.bytes(token)),
        }
    }

    /// Whether `token` is the keyword of a directive.
    pub(super) fn is_keyword(&self, token: Token) -> bool {
        token.kind == TokenKind::Word && rule(self.lexer.bytes(token)).is_some()
    }

    fn not_a_directive(&self, token: Token) {
        let span = self.lexer.span(token);
        let bytes = self.lexer.bytes(token);
        if token.kind != TokenKind::Word || parse_f64(bytes).is_some() {
            let message = format!("expected a directive, found {}", self.describe(token));
            self.report.push(self.syntax_error(token, message));
            return;
        }
        let diagnostic =
            Diagnostic::error("unknown-directive", span, format!("unknown directive {}", quote(bytes)));
        self.report.push_with(diagnostic, |diagnostic| match directive_help(bytes) {
            Some(help) => diagnostic.with_help(help),
            None => diagnostic,
        });
    }

    /// Skips to the next keyword.
    fn recover(&mut self) {
        loop {
            let token = self.lexer.peek();
            if token.kind == TokenKind::End || self.is_keyword(token) {
                return;
            }
            self.lexer.next();
        }
    }
}

/// The error about a string that its line ends.
fn unterminated(span: Span) -> Diagnostic {
    Diagnostic::error("unterminated-string", span, "this string has no closing quote")
        .with_help("a string ends on the line on which it begins")
}

/// What to write instead of an unknown directive.
fn directive_help(word: &[u8]) -> Option<String> {
    let word = str::from_utf8(word).ok()?;
    match word {
        "WorldEnd" => return Some("pbrt-v4 has no `WorldEnd`: the world ends with the file".to_owned()),
        "SurfaceIntegrator" | "VolumeIntegrator" => return Some("pbrt-v4 calls it `Integrator`".to_owned()),
        _ => {}
    }
    let nearest = suggest::nearest(word, RULES.iter().map(|rule| rule.name))?;
    Some(format!("did you mean `{nearest}`?"))
}
