//! Texts that a model reads as control tokens, such as `<|im_end|>`.

use llama_cpp_2::model::LlamaModel;
use llama_cpp_2::token::LlamaToken;
use llama_cpp_2::token_type::LlamaTokenAttr;

/// All control tokens of a model, as text.
pub(super) fn control_tokens(model: &LlamaModel) -> Vec<String> {
    let vocab = model.vocab();
    let is_control = |token: &LlamaToken| {
        vocab.is_control(*token)
            || vocab.is_eog(*token)
            || vocab.attr(*token).contains(LlamaTokenAttr::UserDefined)
    };
    vocab
        .tokens()
        .filter(is_control)
        .filter_map(|token| Some(vocab.text(token)?.to_str().ok()?.to_owned()))
        // Some models count sequences of spaces among them.
        .filter(|text| text.len() > 1 && text.contains(['<', '|', '[']))
        .collect()
}

/// Inserts spaces into a text until it contains no control token.
pub(super) fn break_up(mut text: String, control_tokens: &[String]) -> String {
    for token in control_tokens {
        // Again, since `replace` passes over the second of two overlapping occurrences.
        while text.contains(token.as_str()) {
            let first = token.chars().next().map_or(0, char::len_utf8);
            text = text.replace(
                token.as_str(),
                &format!("{} {}", &token[..first], &token[first..]),
            );
        }
    }
    text
}
