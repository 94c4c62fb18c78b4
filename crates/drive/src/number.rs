//! Structs of numbers that the laws of drive, plant and twin are written over: one axis at a time they
//! are `f64`, in a batch they are vectors with one axis in each lane ([`crate::batch`]).

/// Declares a struct whose fields are numbers of the same kind, with the two conversions that
/// take it from axes to vectors.
macro_rules! numbers {
    ($(#[$meta:meta])* $name:ident { $($(#[$field_meta:meta])* $field:ident,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default)]
        pub(crate) struct $name<N> {
            $($(#[$field_meta])* pub(crate) $field: N,)+
        }

        impl<N> $name<N> {
            /// Every number through a function.
            #[inline(always)]
            pub(crate) fn map<M>(&self, function: impl Fn(&N) -> M) -> $name<M> {
                $name { $($field: function(&self.$field),)+ }
            }

            /// Every number with that of another such struct through a function.
            #[inline(always)]
            #[allow(dead_code, reason = "few of these structs are put together")]
            pub(crate) fn zip<M, O>(&self, other: &$name<M>, function: impl Fn(&N, &M) -> O) -> $name<O> {
                $name { $($field: function(&self.$field, &other.$field),)+ }
            }

            /// Puts every number into its place in another such struct.
            pub(crate) fn put<M>(&mut self, values: &$name<M>, place: impl Fn(&mut N, &M)) {
                $(place(&mut self.$field, &values.$field);)+
            }
        }
    };
}
pub(crate) use numbers;
