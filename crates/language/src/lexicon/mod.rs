//! Words, numbers and marks: the layer below the grammar, which turns a text into lexemes.
//!
//! The grammar knows classes and features of words, not words. A language is a file in
//! [`languages`].
//!
//! | module | its one concept |
//! |---|---|
//! | [`class`], [`feature`] | what words do in an instruction |
//! | [`language`], [`languages`] | what a language file holds, and the files |
//! | [`marks`] | punctuation |
//! | [`folding`], [`tokens`] | a text as folded tokens |
//! | [`words`], [`times`] | the index of all words, and the words that a text is read with |
//! | [`numbers`], [`edit_distance`] | numbers, and words with typing errors |
//! | [`lexeme`], [`lexer`] | tokens as lexemes |

pub(crate) mod class;
mod edit_distance;
pub(crate) mod feature;
mod folding;
mod language;
pub(crate) mod languages;
pub(crate) mod lexeme;
pub(crate) mod lexer;
pub(crate) mod marks;
pub(crate) mod numbers;
pub(crate) mod times;
pub(crate) mod tokens;
pub(crate) mod words;
