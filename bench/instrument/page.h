// bench/instrument/page.h: a page of measurements: text, tables, plots and pictures in their order.
// As HTML it is one file that refers to nothing outside: its style is ours (instrument/page), its
// plots are drawn in it, nothing in it is a program, and its policy forbids the browser to load
// anything. It follows the reader's light or dark setting and prints. As Markdown or as text it has
// the same parts without the plots.
//
// Every text may be hostile (names from a foreign file): it is escaped where it goes. Text that is
// not UTF-8 gets replacement characters; numbers that are not finite are shown as missing.
//
// For one thread. Nothing here throws but for lack of memory.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace plait::instrument {

/// A number that is not known.
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

enum class Tone : std::uint8_t {
  kPlain,
  kGood,
  kDoubt,   ///< amber: what limits the trust in the page
  kFailed,  ///< red; as the tone of the verdict it turns the whole page red
};

/// Logarithmic, so values that are not positive are not shown.
struct Axis {
  std::string label;
  /// How numbers are written: "s", "B" (powers of 1024), or any other text, which follows the
  /// number.
  std::string unit = {};
};

/// The text around a plot or a table.
struct Caption {
  std::string title;
  std::string how_to_read = {};  ///< one line
  std::string command = {};      ///< reproduces the numbers; empty: none is shown
};

struct Table {
  struct Column {
    std::string name;
    bool number = true;  ///< right-aligned
  };
  struct Row {
    std::vector<std::string> cells;
    Tone tone = Tone::kPlain;
  };
  Caption caption = {};
  std::vector<Column> columns = {};
  std::vector<Row> rows = {};
};

/// A table without rows: its columns' names have '|' between them, and those of numbers '#' before.
Table table_with(std::string_view columns, Caption caption = {});
/// Lines with columns as wide as their widest cell, in characters and not in bytes, without what
/// moves a terminal's cursor. If a line would have more than 100 characters, the widest columns of
/// text are narrowed, and their cells have several lines.
std::string to_text(const Table& table);
/// Rows of a Markdown table. A vertical bar in a cell is escaped.
std::string to_markdown(const Table& table);

/// Dots with intervals, a row for each (group, name).
struct IntervalPlot {
  struct Point {
    std::string group, name;  ///< the group may be empty
    double value = kMissing, low = kMissing, high = kMissing;
    std::string note = {};  ///< under the pointer
    bool hollow = false;    ///< drawn as an outline: not to be relied on
  };
  Caption caption = {};
  Axis x = {};
  std::optional<double> reference = {};  ///< a dashed line at this value
  std::vector<Point> points = {};
};

/// Points with two coordinates. Those in front are filled and named.
struct ScatterPlot {
  struct Point {
    std::string series, name;
    double x = kMissing, y = kMissing;
    bool front = false;
    double y_low = kMissing, y_high = kMissing;
  };
  Caption caption = {};
  Axis x = {}, y = {};
  std::vector<Point> points = {};
};

/// One sentence in a box. kFailed turns the page red, and is put before the title in the tab.
struct Verdict {
  std::string text;
  Tone tone;
};
struct Section {
  std::string heading;
};
struct Paragraph {
  std::string text;
};
struct List {
  std::vector<std::string> items;
  Tone tone;
};
/// A command to paste, in a box.
struct Command {
  std::string text;
};
/// Not in HTML.
struct Picture {
  std::filesystem::path file;
  std::string caption;
};
/// A plot without points is left out.
using Part = std::variant<Verdict, Section, Paragraph, List, Command, Picture, Table, IntervalPlot,
                          ScatterPlot>;

struct Page {
  std::string title;  ///< as text, an empty one is left out
  std::string subtitle = {};
  std::vector<Part> parts = {};

  void add(Part part) { parts.push_back(std::move(part)); }
};
std::string to_html(const Page& page);
/// Lines of at most 110 characters where words allow it. Pictures are linked relative to
/// `directory`, where the page will be.
std::string to_markdown(const Page& page, const std::filesystem::path& directory);
/// For a terminal.
std::string to_text(const Page& page);

/// The names that have a colour, each by its place here.
using SeriesNames = std::vector<std::string>;
/// A plot of to_html() as SVG. Adds names that are new to `series`, so that a name looks the same
/// on the whole page. Marks have their values in data-value, or in data-x and data-y, and what they
/// are in a title, which browsers show under the pointer; grid lines have theirs in data-tick.
/// Pinned by page_test.cpp.
std::string svg_plot(const IntervalPlot& plot, SeriesNames& series);
std::string svg_plot(const ScatterPlot& plot, SeriesNames& series);

/// `text` for HTML: the characters & < > " ' become entities. Pinned by page_test.cpp.
std::string escape_html(std::string_view text);

}  // namespace plait::instrument
