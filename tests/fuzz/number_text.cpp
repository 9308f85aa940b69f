// Compares the parsing of numbers in mesh files with the C library's.
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>

#include "mesh/files/text_input.h"
#include "oracle.h"

using namespace plait;
using namespace plait::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string word(reinterpret_cast<const char*>(data), size);
  if (const std::optional<std::int64_t> integer = parse_integer(word)) {
    char* end = nullptr;
    errno = 0;
    require(*integer == std::strtoll(word.c_str(), &end, 10) && errno == 0);
    require(end == word.data() + word.size());
  }
  // strtod also reads blanks before a number, and hexadecimal numbers. Mesh files have neither.
  const std::size_t x = word.find_first_of("xX");
  const bool is_hexadecimal = x != std::string::npos && x == word.find_first_not_of("+-0");
  const bool is_decimal = !is_hexadecimal && word.find_first_of(" \t\n\v\f\r") == std::string::npos;
  char* end = nullptr;
  const double expected = std::strtod(word.c_str(), &end);
  const bool is_number = is_decimal && !word.empty() && end == word.data() + word.size();
  const bool overflows =
      is_number && std::isinf(expected) && word.find_first_of("iI") == std::string::npos;
  const std::optional<double> number = parse_plain_number(word);
  (void)parse_foreign_number(word);
  require(number.has_value() == (is_number && !overflows));
  if (!number || (std::isnan(*number) && std::isnan(expected))) return 0;
  // The smallest numbers may become zero.
  require(*number == expected || (*number == 0 && std::abs(expected) < 1e-300));
  return 0;
}
