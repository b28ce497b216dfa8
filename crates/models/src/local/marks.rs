//! The texts that a model takes for marks of a conversation, such as `<|im_end|>`.

use llama_cpp_2::model::LlamaModel;
use llama_cpp_2::token::LlamaToken;
use llama_cpp_2::token_type::LlamaTokenAttr;

/// All marks of a model.
pub(super) fn marks_of(model: &LlamaModel) -> Vec<String> {
    let vocab = model.vocab();
    let is_mark = |token: &LlamaToken| {
        vocab.is_control(*token)
            || vocab.is_eog(*token)
            || vocab.attr(*token).contains(LlamaTokenAttr::UserDefined)
    };
    vocab
        .tokens()
        .filter(is_mark)
        .filter_map(|token| Some(vocab.text(token)?.to_str().ok()?.to_owned()))
        // Some models keep runs of blanks among them.
        .filter(|mark| mark.len() > 1 && mark.contains(['<', '|', '[']))
        .collect()
}

/// A text in which no mark is whole any more.
pub(super) fn without_marks(mut text: String, marks: &[String]) -> String {
    for mark in marks {
        while text.contains(mark.as_str()) {
            let first = mark.chars().next().map_or(0, char::len_utf8);
            text = text.replace(mark.as_str(), &format!("{} {}", &mark[..first], &mark[first..]));
        }
    }
    text
}
