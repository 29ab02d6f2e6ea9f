//! A position in a list of tokens, with operations to consume them.

use crate::fault::{Fault, foreign};
use crate::lexer::{Placed, Token, tokens};
use crate::same;

/// The maximum nesting depth of expressions and statements.
const DEPTH: u32 = 60;

/// A position in a list of tokens. Line ends are skipped, except by [`Cursor::is_line_end`].
pub(super) struct Cursor {
    tokens: Vec<Placed>,
    at: usize,
    depth: u32,
}

impl Cursor {
    pub(super) fn new(text: &str, line: u32) -> Result<Cursor, Fault> {
        Ok(Cursor { tokens: tokens(text, line, true)?, at: 0, depth: 0 })
    }

    fn skip_lines(&mut self) {
        while self.tokens[self.at].token == Token::Line {
            self.at += 1;
        }
    }

    /// The current position, for [`Cursor::back_to`].
    pub(super) fn place(&self) -> usize {
        self.at
    }

    pub(super) fn back_to(&mut self, place: usize) {
        self.at = place;
    }

    /// The next token, without consuming it.
    pub(super) fn peek(&mut self) -> &Token {
        self.skip_lines();
        &self.tokens[self.at].token
    }

    /// The token after the next one.
    pub(super) fn second(&mut self) -> &Token {
        self.skip_lines();
        let rest = self.tokens[self.at + 1..].iter();
        rest.map(|placed| &placed.token).find(|token| **token != Token::Line).unwrap_or(&Token::End)
    }

    pub(super) fn line(&mut self) -> u32 {
        self.skip_lines();
        self.tokens[self.at].line
    }

    pub(super) fn next(&mut self) -> Token {
        self.skip_lines();
        let token = self.tokens[self.at].token.clone();
        if token != Token::End {
            self.at += 1;
        }
        token
    }

    /// Whether the next token is a line end or the end of the text.
    pub(super) fn is_line_end(&self) -> bool {
        matches!(self.tokens[self.at].token, Token::Line | Token::End)
    }

    pub(super) fn is_sign(&mut self, sign: &str) -> bool {
        matches!(self.peek(), Token::Sign(own) if *own == sign)
    }

    pub(super) fn take_sign(&mut self, sign: &str) -> bool {
        let is = self.is_sign(sign);
        if is {
            self.next();
        }
        is
    }

    pub(super) fn sign(&mut self, sign: &str) -> Result<(), Fault> {
        if self.take_sign(sign) { Ok(()) } else { Err(self.unexpected(&format!("'{sign}'"))) }
    }

    /// Whether the next token is this word, ignoring case.
    pub(super) fn is_word(&mut self, word: &str) -> bool {
        matches!(self.peek(), Token::Word(own) if same(own, word))
    }

    pub(super) fn is_one_of(&mut self, words: &[&str]) -> bool {
        matches!(self.peek(), Token::Word(own) if words.iter().any(|word| same(own, word)))
    }

    pub(super) fn take_word(&mut self, word: &str) -> bool {
        let is = self.is_word(word);
        if is {
            self.next();
        }
        is
    }

    pub(super) fn word(&mut self, word: &str) -> Result<(), Fault> {
        if self.take_word(word) { Ok(()) } else { Err(self.unexpected(word)) }
    }

    /// Consumes a pragma that a controller may execute, and returns its text; `None` if the next token is another one.
    pub(super) fn take_pragma(&mut self) -> Option<String> {
        let Token::Pragma(text) = self.peek().clone() else { return None };
        self.next();
        Some(text)
    }

    /// Consumes a name; a fault that `what` was expected if there is none.
    pub(super) fn name(&mut self, what: &str) -> Result<String, Fault> {
        match self.peek() {
            Token::Word(_) => match self.next() {
                Token::Word(name) => Ok(name),
                _ => Ok(String::new()),
            },
            _ => Err(self.unexpected(what)),
        }
    }

    pub(super) fn end(&mut self) -> Result<(), Fault> {
        if *self.peek() == Token::End { Ok(()) } else { Err(self.unexpected("the end")) }
    }

    /// Runs `inner` one nesting level deeper; a fault if the depth limit is exceeded.
    pub(super) fn deeper<T>(
        &mut self,
        inner: impl FnOnce(&mut Cursor) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        if self.depth >= DEPTH {
            let line = self.line();
            return Err(Fault::new(line, format!("more than {DEPTH} levels are nested")));
        }
        self.depth += 1;
        let found = inner(self);
        self.depth -= 1;
        found
    }

    /// The fault that `what` was expected instead of the next token.
    pub(super) fn unexpected(&mut self, what: &str) -> Fault {
        let line = self.line();
        let found = match self.peek() {
            Token::Pragma(text) => {
                let help = "facts can state the effect of a pragma only between statements: take it out of a copy of the file if it does nothing";
                return foreign(text, line).help(help);
            }
            Token::Word(text) | Token::Number(text) | Token::Direct(text) => format!("'{text}'"),
            Token::Text(text) => format!("the text '{text}'"),
            Token::Sign(sign) => format!("'{sign}'"),
            Token::Line | Token::End => "the end".to_owned(),
        };
        Fault::new(line, format!("{what} was expected, but {found} was found"))
    }
}
