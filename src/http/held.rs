//! What was read of the store, together with the memory that was set aside for it.

use std::ops::Deref;

use tokio::sync::OwnedSemaphorePermit;

/// A value with the room for it and for what is made of it, which others have again once it is dropped: it goes with the
/// value into the work that needs it.
pub struct Held<T> {
    value: T,
    room: OwnedSemaphorePermit,
}

impl<T> Held<T> {
    pub fn new(value: T, room: OwnedSemaphorePermit) -> Held<T> {
        Held { value, room }
    }

    /// What `f` makes of the value, in the same room.
    pub fn map<U>(self, f: impl FnOnce(T) -> U) -> Held<U> {
        Held { value: f(self.value), room: self.room }
    }
}

impl<T> Deref for Held<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}
