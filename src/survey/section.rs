//! One declaration per section of a file: the type, its keys with limits, its defaults and what the documentation says of them.

/// Declares a section.
///
/// Every key is one entry: its documentation, its name and type, `required` or `or` with the default, and its
/// [`Kind`](super::schema::Kind). A key whose default is `None` may be left out. Written again, a section shows every value as it took
/// effect.
///
/// What comes of it: the struct with serde both ways (unknown keys refused), `KEYS` for the reader's check, the template and the page of
/// keys. A last entry `aside`, or several, is a field that no file has: another section of the file fills it. With `#[settings]` before the struct, where every key has a default, also [`Default`].
macro_rules! section {
    (
        #[settings]
        $(#[$meta:meta])*
        pub struct $name:ident { $($fields:tt)* }
    ) => {
        $crate::survey::section::section! { $(#[$meta])* pub struct $name { $($fields)* } }
        $crate::survey::section::section! { @default $name { $($fields)* } }
    };
    (
        $(#[$meta:meta])*
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])+
                $(#[serde($($serde:tt)*)])?
                $field:ident: $type:ty = $rule:ident $(($default:expr))?, $kind:expr;
            )*
            $(aside $(#[doc = $about:literal])+ $aside:ident: $of:ty = $start:expr;)*
        }
    ) => {
        $(#[$meta])*
        #[derive(serde::Serialize)]
        pub struct $name {
            $(
                $(#[doc = $doc])+
                $(#[serde($($serde)*)])?
                pub $field: $type,
            )*
            $(
                $(#[doc = $about])+
                #[serde(skip)]
                pub $aside: $of,
            )*
        }

        impl $name {
            /// The keys of this section.
            pub const KEYS: &'static [$crate::survey::schema::Key] = &[$(
                $crate::survey::schema::Key {
                    name: stringify!($field),
                    kind: $kind,
                    required: $crate::survey::section::section!(@required $rule),
                    about: concat!($($doc, "\n"),+),
                    default: $crate::survey::section::section!(@shown $type, $rule $(($default))?),
                },
            )*];
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
                #[derive(serde::Deserialize)]
                #[serde(deny_unknown_fields)]
                struct Given {
                    $($field: Option<$type>,)*
                }
                let given = <Given as serde::Deserialize>::deserialize(source)?;
                Ok(Self {
                    $($field: $crate::survey::section::section!(
                        @value given.$field, stringify!($field), $rule $(($default))?
                    ),)*
                    $($aside: $start,)*
                })
            }
        }
    };
    (@default $name:ident {
        $(
            $(#[doc = $doc:literal])+
            $(#[serde($($serde:tt)*)])?
            $field:ident: $type:ty = or ($default:expr), $kind:expr;
        )*
        $(aside $(#[doc = $about:literal])+ $aside:ident: $of:ty = $start:expr;)*
    }) => {
        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* $($aside: $start,)* }
            }
        }
    };
    (@required required) => { true };
    (@required or) => { false };
    (@shown $type:ty, required) => { None };
    (@shown $type:ty, or ($default:expr)) => {
        Some(|| {
            let value: $type = $default;
            toml::Value::try_from(value).ok()
        })
    };
    (@value $given:expr, $name:expr, required) => {
        $given.ok_or_else(|| <D::Error as serde::de::Error>::missing_field($name))?
    };
    (@value $given:expr, $name:expr, or ($default:expr)) => {
        $given.unwrap_or_else(|| $default)
    };
}

pub(crate) use section;
