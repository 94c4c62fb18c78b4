//! Published parsers on the same bytes. They interpret nothing: no modes, no expressions.

use async_gcode::{GCode, Parser, RealValue};
use futures::stream;
use gcode::core::{
    BlockVisitor, CommandVisitor, ControlFlow, Diagnostics, HasDiagnostics, Noop, Number,
    ProgramVisitor, Span, Value,
};
use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// Sum of all arguments, as `gcode`'s visitors see them (f32).
#[derive(Default)]
struct Sum {
    sum: f64,
    ignored: Noop,
}

struct Part<'a>(&'a mut Sum);

impl HasDiagnostics for Sum {
    fn diagnostics(&mut self) -> &mut dyn Diagnostics {
        &mut self.ignored
    }
}

impl HasDiagnostics for Part<'_> {
    fn diagnostics(&mut self) -> &mut dyn Diagnostics {
        &mut self.0.ignored
    }
}

impl Part<'_> {
    fn add(&mut self, value: &Value<'_>) {
        if let Value::Literal(value) = value {
            self.0.sum += f64::from(*value);
        }
    }
}

impl ProgramVisitor for Sum {
    fn start_block(&mut self) -> ControlFlow<impl BlockVisitor + '_> {
        ControlFlow::Continue(Part(self))
    }
}

impl BlockVisitor for Part<'_> {
    fn word_address(&mut self, _: char, value: Value<'_>, _: Span) {
        self.add(&value);
    }

    fn start_general_code(&mut self, _: Number) -> ControlFlow<impl CommandVisitor + '_> {
        ControlFlow::Continue(Part(self.0))
    }

    fn start_miscellaneous_code(&mut self, _: Number) -> ControlFlow<impl CommandVisitor + '_> {
        ControlFlow::Continue(Part(self.0))
    }

    fn start_tool_change_code(&mut self, _: Number) -> ControlFlow<impl CommandVisitor + '_> {
        ControlFlow::Continue(Part(self.0))
    }
}

impl CommandVisitor for Part<'_> {
    fn argument(&mut self, _: char, value: Value<'_>, _: Span) {
        self.add(&value);
    }
}

/// `gcode`, without an allocation.
pub(crate) fn gcode_visitor(text: &str) -> f64 {
    let mut sum = Sum::default();
    gcode::core::parse(text, &mut sum);
    sum.sum
}

/// `async-gcode` on a stream that is always ready.
pub(crate) fn async_gcode(text: &str) -> f64 {
    let mut parser = Parser::new(stream::iter(text.bytes().map(Ok::<u8, async_gcode::Error>)));
    let all = async {
        let mut sum = 0.0;
        while let Some(item) = parser.next().await {
            if let Ok(GCode::Word(_, RealValue::Literal(value))) = item {
                sum += value.as_real_number().unwrap_or_default();
            }
        }
        sum
    };
    match pin!(all).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(sum) => sum,
        Poll::Pending => panic!("the stream is always ready"),
    }
}
