// bench/instrument/page.h: a page of measurements: text, tables, plots and pictures in their order.
// As HTML it is one file that refers to nothing outside: its style is ours (instrument/page), its
// plots are drawn in it, and its policy forbids the browser to load anything. It follows the
// reader's light or dark setting and prints; a script only sorts tables. As Markdown or as text it
// has the same parts without the plots.
//
// Every text may be hostile (names from a foreign file): it is escaped where it goes. Text that is
// not UTF-8 gets replacement characters; numbers that are not finite are shown as missing.
//
// For one thread. Nothing here throws but for lack of memory.
#pragma once

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
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

enum class Scale : std::uint8_t {
  kLinear,
  kLog,
};

struct Axis {
  std::string label;
  /// How numbers are written: "s", "B" (powers of 1024), "B/s" (powers of 1000), "x" (a factor), or
  /// any other text, which follows the number.
  std::string unit = {};
  Scale scale = Scale::kLinear;
};

/// The text around a plot or a table.
struct Caption {
  std::string title;
  std::string how_to_read = {};  ///< one line
  std::string command = {};      ///< reproduces the numbers; empty: none is shown
};

/// A cell of a table: what is shown, and the number that it sorts by. Cells are written as their
/// text, so the first two constructors are implicit.
struct TableCell {
  TableCell(std::string shown) : text(std::move(shown)) {}  // NOLINT
  TableCell(const char* shown) : text(shown) {}             // NOLINT
  TableCell(std::string shown, double number) : text(std::move(shown)), value(number) {}

  std::string text;
  std::optional<double> value = {};
};

struct Table {
  struct Column {
    std::string name;
    bool number = true;  ///< right-aligned
  };
  struct Row {
    std::vector<TableCell> cells;
    Tone tone = Tone::kPlain;
  };
  Caption caption = {};
  std::vector<Column> columns = {};
  std::vector<Row> rows = {};
};

/// A table without rows: its columns' names have '|' between them, and those of numbers '#' before.
Table table_with(std::string_view columns, Caption caption = {});
/// Lines with columns as wide as their widest cell, in characters and not in bytes, without what
/// moves a terminal's cursor. A heading of an empty first column is left out like any other.
std::string to_text(const Table& table);
/// Rows of a Markdown table. A vertical bar in a cell is escaped.
std::string to_markdown(const Table& table);

/// Dots with intervals, a row for each (group, name).
struct IntervalPlot {
  struct Point {
    std::string group, name;  ///< the group may be empty
    double value = kMissing, low = kMissing, high = kMissing;
    std::string note = {};  ///< shown with the numbers
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

/// A plot of fewer points is a table, unless it is a ScatterPlot.
constexpr std::size_t kLeastPoints = 20;

class Page {
 public:
  explicit Page(std::string title, std::string subtitle = {});

  /// One sentence in a box. kFailed turns the page red, and is put before the title in the tab.
  void verdict(std::string sentence, Tone tone) {
    parts_.emplace_back(Verdict{std::move(sentence), tone});
  }
  void section(std::string heading) { parts_.emplace_back(Section{std::move(heading)}); }
  void paragraph(std::string text) { parts_.emplace_back(Paragraph{std::move(text)}); }
  void list(std::vector<std::string> items, Tone tone) {
    parts_.emplace_back(List{std::move(items), tone});
  }
  /// A command to paste, in a box.
  void command(std::string text) { parts_.emplace_back(Command{std::move(text)}); }
  void table(Table table) { parts_.emplace_back(std::move(table)); }
  /// A plot without anything to draw is left out, and a line says so; one of fewer points than a
  /// table shows at a glance is a table.
  void plot(IntervalPlot plot) { parts_.emplace_back(std::move(plot)); }
  void plot(ScatterPlot plot) { parts_.emplace_back(std::move(plot)); }
  /// Not in HTML.
  void picture(std::filesystem::path file, std::string caption) {
    parts_.emplace_back(Picture{std::move(file), std::move(caption)});
  }
  /// Puts data into the HTML, for programs that read it: <script type="application/json" id="ID">.
  /// REQUIRES: `id` is made of letters.
  void embed(std::string id, nlohmann::ordered_json data) {
    parts_.emplace_back(Data{std::move(id), std::move(data)});
  }

  std::string html() const;
  /// Lines of at most 110 characters where words allow it. Pictures are linked relative to
  /// `directory`, where the page will be.
  std::string markdown(const std::filesystem::path& directory) const;
  std::string text() const;

 private:
  friend class HtmlWriter;
  struct Verdict {
    std::string text;
    Tone tone;
  };
  struct Section {
    std::string text;
  };
  struct Paragraph {
    std::string text;
  };
  struct List {
    std::vector<std::string> items;
    Tone tone;
  };
  struct Command {
    std::string text;
  };
  struct Picture {
    std::filesystem::path file;
    std::string caption;
  };
  struct Data {
    std::string id;
    nlohmann::ordered_json data;
  };
  using Part = std::variant<Verdict, Section, Paragraph, List, Command, Table, IntervalPlot,
                            ScatterPlot, Picture, Data>;

  std::string title_, subtitle_;
  std::vector<Part> parts_;
};

/// `text` for HTML: the characters & < > " ' become entities. Pinned by page_test.cpp.
std::string escape_html(std::string_view text);

/// `data` for a <script>: no text in it can end the script.
std::string script_json(const nlohmann::ordered_json& data);

}  // namespace plait::instrument
