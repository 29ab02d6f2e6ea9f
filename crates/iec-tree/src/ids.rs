//! Ids: numbers of what a project declares.

/// An id of something that is declared: its number among all of its kind.
macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident,)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub struct $name(pub u32);

        impl $name {
            /// The id of this number.
            #[must_use]
            pub fn at(number: usize) -> $name {
                $name(u32::try_from(number).unwrap_or(u32::MAX))
            }

            /// Its number.
            #[must_use]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}

ids! {
    /// A variable.
    VarId,
    /// A program, a function block, a function or an interface.
    UnitId,
    /// A body, an action or a method.
    RoutineId,
    /// A direct address that code names (`%IX0.1`).
    AddressId,
    /// A value that a list or a drawing keeps from one statement to others of its body.
    TempId,
}
