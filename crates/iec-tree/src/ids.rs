//! Typed ids: indices into the tables of [`crate::tree::Tree`].

/// Defines an id type: the index of a declaration among all of its kind.
macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident,)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub struct $name(pub u32);

        impl $name {
            /// The id with this index.
            #[must_use]
            pub fn at(number: usize) -> $name {
                $name(u32::try_from(number).unwrap_or(u32::MAX))
            }

            /// The index in its table.
            #[must_use]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}

ids! {
    /// The id of a variable.
    VarId,
    /// The id of a program, a function block, a function or an interface.
    UnitId,
    /// The id of a body, an action or a method.
    RoutineId,
    /// The id of a direct address that code names (`%IX0.1`).
    AddressId,
    /// The id of a temporary: a value that a statement list or drawing stores for later statements of the same body.
    TempId,
}
