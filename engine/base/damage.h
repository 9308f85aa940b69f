// base/damage.h: the words with which an error about damaged bytes tells what helps.
#pragma once

#include <fmt/format.h>

#include <exception>
#include <string>
#include <string_view>

#include "plait/detail/namespace.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

inline constexpr std::string_view kDamageCure =
    "; `plait repair` (plait::repair) mends what it can";

/// An error about damaged bytes of a store with these words, any other error as it is.
inline Error with_cure(const Error& error) {
  if (error.code() != ErrorCode::kCorruption ||
      std::string_view(error.what()).ends_with(kDamageCure))
    return error;
  return Error(error, fmt::format("{}{}", error.what(), kDamageCure));
}

/// The message without these words: for verify and repair, which say more.
inline std::string without_cure(const std::exception& error) {
  std::string_view text = error.what();
  if (text.ends_with(kDamageCure)) text.remove_suffix(kDamageCure.size());
  return std::string(text);
}

PLAIT_END_NAMESPACE
