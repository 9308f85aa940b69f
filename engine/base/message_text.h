// base/message_text.h: text of a user or of a file, as a message may quote it.
#pragma once

#include <string>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// At most the first 100 characters, with a question mark for each that is not printable ASCII: a
/// message is one line, and a terminal may take other bytes for commands.
std::string text_for_message(std::string_view text);

PLAIT_END_NAMESPACE
