// stl_text.h: the facets of a text STL file, one after another. Words are apart by blanks or line
// ends, wherever these stand, and in any case; `end loop`, `end facet` and `end solid` may be two
// words. A name runs to the end of its line, or to a facet that follows on it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "mesh/files/text_input.h"
#include "plait/detail/namespace.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class StlText {
 public:
  explicit StlText(Input& input) : text_(input, {.divides_long_words = true}) {}

  /// Reads the corners of the next facet. Returns false at the end of the file.
  /// Errors: kInvalidArgument with line, facet, expected and found.
  bool next_facet(std::array<Vector3<double>, 3>& corners);

  std::uint64_t solids() const { return solids_; }
  bool has_end() const { return has_end_; }  ///< `endsolid` is behind the last facet

  /// Throws kInvalidArgument with the place and the word.
  [[noreturn]] void refuse(std::string_view expected) const;

 private:
  /// Goes to the next word, which then is empty at the end of the file.
  void next();
  /// Whether the word, or with its successor, is `end` with `of` behind it. Goes behind both.
  bool take_end(std::string_view of);
  /// Passes the name behind a word. Returns whether a facet has begun on its line.
  bool pass_name();
  /// Passes the numbers of a normal, which the corners give as well, and `outer loop`.
  void pass_normal();
  void read_vertex(Vector3<double>& corner);

  TextInput text_;
  std::string word_;   ///< the present word, in lower case
  std::string found_;  ///< as the file has it
  bool has_begun_ = false, has_end_ = false;
  std::uint64_t facets_ = 0, solids_ = 0;
};

PLAIT_END_NAMESPACE
