#include "base/message_text.h"

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::string text_for_message(std::string_view text) {
  std::string shown(text.substr(0, 100));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return shown;
}

PLAIT_END_NAMESPACE
