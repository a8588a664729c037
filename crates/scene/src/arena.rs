//! Typed handles and the arenas they index.

use std::fmt;
use std::marker::PhantomData;
use std::ops::{Index, IndexMut};

use serde::{Deserialize, Serialize};

use crate::Span;

/// A reference to a `T` in an [`Arena<T>`]: four bytes, `Copy`, and of no use with another arena.
#[derive(Serialize, Deserialize)]
#[serde(transparent)]
pub struct Handle<T> {
    index: u32,
    #[serde(skip)]
    target: PhantomData<fn() -> T>,
}

impl<T> Handle<T> {
    /// The handle of the entry at `index`.
    #[inline]
    pub const fn new(index: u32) -> Self {
        Self { index, target: PhantomData }
    }

    /// The position in the arena.
    #[inline]
    pub const fn index(self) -> usize {
        self.index as usize
    }
}

// Derived, these would ask the same of `T`.
impl<T> Clone for Handle<T> {
    #[inline]
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Handle<T> {}
impl<T> PartialEq for Handle<T> {
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        self.index == other.index
    }
}
impl<T> Eq for Handle<T> {}
impl<T> std::hash::Hash for Handle<T> {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.index.hash(state);
    }
}
impl<T> fmt::Debug for Handle<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{}", self.index)
    }
}

/// Where an entity comes from: its name in the file, if it has one, and the text that defines it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The name given in the file.
    pub name: Option<String>,
    /// The text that defines the entity; `None` for what a loader or a program made up.
    pub span: Option<Span>,
}

impl Origin {
    /// An entity without a name, defined at `span`.
    pub fn at(span: Span) -> Self {
        Self { name: None, span: Some(span) }
    }

    /// An entity called `name`, defined at `span`.
    pub fn named(name: impl Into<String>, span: Span) -> Self {
        Self { name: Some(name.into()), span: Some(span) }
    }
}

/// Values of one kind with their origins, addressed by [`Handle`]s in the order in which they were added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arena<T> {
    values: Vec<T>,
    origins: Vec<Origin>,
}

impl<T> Default for Arena<T> {
    fn default() -> Self {
        Self { values: Vec::new(), origins: Vec::new() }
    }
}

impl<T> Arena<T> {
    /// Adds a value.
    ///
    /// # Panics
    /// If the arena already holds 2³² values.
    pub fn push(&mut self, value: T, origin: Origin) -> Handle<T> {
        let index = u32::try_from(self.values.len()).expect("fewer than 2^32 entities of a kind");
        self.values.push(value);
        self.origins.push(origin);
        Handle::new(index)
    }

    /// The value, or `None` if the handle comes from elsewhere.
    pub fn get(&self, handle: Handle<T>) -> Option<&T> {
        self.values.get(handle.index())
    }

    /// Where the value comes from; nowhere if the handle comes from elsewhere.
    pub fn origin(&self, handle: Handle<T>) -> &Origin {
        const NOWHERE: &Origin = &Origin { name: None, span: None };
        self.origins.get(handle.index()).unwrap_or(NOWHERE)
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The values in order.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// Handles and values in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (Handle<T>, &T)> {
        self.values.iter().enumerate().map(|(index, value)| (Handle::new(index as u32), value))
    }
}

impl<T> Index<Handle<T>> for Arena<T> {
    type Output = T;
    fn index(&self, handle: Handle<T>) -> &T {
        &self.values[handle.index()]
    }
}

impl<T> IndexMut<Handle<T>> for Arena<T> {
    fn index_mut(&mut self, handle: Handle<T>) -> &mut T {
        &mut self.values[handle.index()]
    }
}
