// Pages and tables as text and as Markdown.
#include <fmt/format.h>

#include <algorithm>
#include <boost/algorithm/string/replace.hpp>
#include <sstream>

#include "instrument/figure_text.h"
#include "instrument/page.h"

namespace plait::instrument {
namespace {

constexpr std::size_t kLineWidth = 100;
/// A column of text is not made narrower than this.
constexpr std::size_t kNarrowest = 14;

/// The headings and the rows.
std::vector<std::vector<std::string>> texts_of(const Table& table) {
  std::vector<std::vector<std::string>> rows(1);
  for (const Table::Column& column : table.columns) rows[0].push_back(column.name);
  for (const Table::Row& row : table.rows) rows.push_back(row.cells);
  return rows;
}

/// Narrows the widest columns of text until they fit into a line.
void narrow(std::vector<std::size_t>& widths, const Table& table) {
  std::size_t all = 2 * (widths.size() - 1);
  for (const std::size_t width : widths) all += width;
  for (; all > kLineWidth; --all) {
    std::size_t* widest = nullptr;
    for (std::size_t at = 0; at < widths.size(); ++at)
      if (!table.columns[at].number && widths[at] > kNarrowest &&
          (widest == nullptr || widths[at] > *widest))
        widest = &widths[at];
    if (widest == nullptr) return;
    --*widest;
  }
}

/// The lines of a cell in a column of this width.
std::vector<std::string> lines_of(const std::string& cell, std::size_t width) {
  if (width_of(cell) <= width) return {cell};
  std::vector<std::string> lines;
  std::istringstream text(wrapped(cell, width, {}));
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

}  // namespace

Table table_with(std::string_view columns, Caption caption) {
  Table table{std::move(caption), {}, {}};
  for (std::size_t at = 0; at <= columns.size();) {
    const std::size_t end = std::min(columns.find('|', at), columns.size());
    const bool number = at < end && columns[at] == '#';
    table.columns.push_back({std::string(columns.substr(at + number, end - at - number)), number});
    at = end + 1;
  }
  return table;
}

std::string to_text(const Table& table) {
  std::vector<std::vector<std::string>> rows = texts_of(table);
  std::vector<std::size_t> widths(table.columns.size(), 0);
  for (auto& row : rows) {
    row.resize(widths.size());
    for (std::size_t at = 0; at < row.size(); ++at) {
      row[at] = printable(std::move(row[at]));
      widths[at] = std::max(widths[at], width_of(row[at]));
    }
  }
  if (!widths.empty()) narrow(widths, table);
  std::string text;
  for (const auto& row : rows) {
    std::vector<std::vector<std::string>> cells;
    std::size_t height = 1;
    for (std::size_t at = 0; at < row.size(); ++at)
      height = std::max(height, cells.emplace_back(lines_of(row[at], widths[at])).size());
    for (std::size_t down = 0; down < height; ++down) {
      std::string line;
      for (std::size_t at = 0; at < cells.size(); ++at) {
        const std::string cell = down < cells[at].size() ? cells[at][down] : std::string();
        const std::size_t width = width_of(cell);  // a word may be wider than its column
        const std::string space(widths[at] - std::min(width, widths[at]), ' ');
        line += (at == 0 ? "" : "  ") + (table.columns[at].number ? space + cell : cell + space);
      }
      text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
  }
  return text;
}

std::string to_markdown(const Table& table) {
  std::string text;
  for (const auto& row : texts_of(table)) {
    const bool is_first = text.empty();
    text += "|";
    for (const std::string& cell : row)
      text += fmt::format(" {} |", boost::replace_all_copy(cell, "|", "\\|"));
    text += "\n";
    if (!is_first) continue;
    text += "|";
    for (const Table::Column& column : table.columns) text += column.number ? "---:|" : "---|";
    text += "\n";
  }
  return text;
}

namespace {

/// Parts as lines.
struct TextWriter {
  bool markdown;
  std::filesystem::path here;  ///< where links begin
  const char* gap = markdown ? "\n" : "";

  std::string operator()(const Section& of) const {
    return markdown ? fmt::format("## {}\n", of.heading)
                    : fmt::format("\n{}\n{:-<{}}\n", of.heading, "", of.heading.size());
  }
  std::string operator()(const Verdict& of) const { return (*this)(Paragraph{of.text}); }
  std::string operator()(const Paragraph& of) const {
    return wrapped(printable(of.text), kLineWidth) + gap;
  }
  std::string operator()(const List& of) const {
    std::string lines;
    for (const std::string& item : of.items)
      lines += wrapped("- " + printable(item), kLineWidth, "  ");
    return lines + gap;
  }
  std::string operator()(const Command& of) const {
    return fmt::format("    {}\n{}", of.text, gap);
  }
  std::string operator()(const Picture& of) const {
    if (!markdown) return fmt::format("{}: {}\n", of.file.native(), of.caption);
    const auto file = std::filesystem::absolute(of.file).lexically_normal();
    return fmt::format("![{}]({})\n\n", of.caption, file.lexically_relative(here).generic_string());
  }
  std::string operator()(const Table& of) const {
    return markdown ? to_markdown(of) + "\n" : fmt::format("\n{}\n", to_text(of));
  }
  std::string operator()(const auto&) const { return {}; }  // plots
};

}  // namespace

std::string to_markdown(const Page& page, const std::filesystem::path& directory) {
  const TextWriter writer{true, std::filesystem::absolute(directory).lexically_normal()};
  std::string text = fmt::format("# {}\n", page.title);
  for (const Part& part : page.parts) text += std::visit(writer, part);
  while (text.ends_with("\n\n")) text.pop_back();
  return text;
}

std::string to_text(const Page& page) {
  const TextWriter writer{false, {}};
  std::string text = page.title.empty() ? "" : page.title + "\n";
  for (const Part& part : page.parts) text += std::visit(writer, part);
  return text;
}

}  // namespace plait::instrument
