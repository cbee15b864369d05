//! Undo: what was asked for, before each edit that came to rest.

use super::Asked;

/// Most states that are kept.
const DEPTH: usize = 200;

/// A line of states with a place in it.
pub struct History {
    states: Vec<Asked>,
    at: usize,
}

impl History {
    /// Begins with one state.
    pub fn new(first: Asked) -> Self {
        Self { states: vec![first], at: 0 }
    }

    /// Notes a state once it rests (a slider that is still held is no edit yet). What was undone is then gone.
    pub fn note(&mut self, asked: &Asked) {
        if self.states.get(self.at) == Some(asked) {
            return;
        }
        self.states.truncate(self.at + 1);
        self.states.push(asked.clone());
        if self.states.len() > DEPTH {
            self.states.remove(0);
        }
        self.at = self.states.len() - 1;
    }

    /// The state before, if there is one.
    pub fn back(&mut self) -> Option<Asked> {
        self.at = self.at.checked_sub(1)?;
        self.states.get(self.at).cloned()
    }

    /// The state that was undone last.
    pub fn forth(&mut self) -> Option<Asked> {
        let next = self.states.get(self.at + 1).cloned()?;
        self.at += 1;
        Some(next)
    }

    /// Whether there is something to undo.
    pub fn has_back(&self) -> bool {
        self.at > 0
    }

    /// Whether there is something to do again.
    pub fn has_forth(&self) -> bool {
        self.at + 1 < self.states.len()
    }
}
