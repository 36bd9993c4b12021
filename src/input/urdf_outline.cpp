#include "input/urdf_outline.hpp"

#include <expat.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "core/suggest.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_faults = 20;      // the number that format() shows
constexpr std::size_t most_depth = 256;      // real robots stay below 10
constexpr int most_attributes = 1000;        // of one element
constexpr std::size_t most_nodes = 1000000;  // elements and attributes kept: about 27000 links

constexpr std::size_t longest_word =
    24;  // longer words are not compared: the longest URDF word has 17 letters
constexpr std::size_t most_foreign =
    10000;  // unknown words that are compared with known ones, which bounds the time

using Names = std::vector<std::string>;

/// Allowed contents of an element: `many` and `once` are read, `ignored` is skipped. Any other name is
/// foreign (a tag of a simulator) unless it resembles a known one.
struct Vocabulary {
  std::string_view element;
  Names many, once, ignored, attributes;
};

const Vocabulary* vocabulary(std::string_view element) {
  static const std::vector<Vocabulary> rows = {
      {"robot", {"link", "joint"}, {}, {"material", "gazebo", "transmission", "sensor"}, {"name", "version"}},
      {"link", {}, {"inertial"}, {"visual", "collision", "contact", "origin"}, {"name", "type"}},
      {"inertial", {}, {"origin", "mass", "inertia"}, {}, {}},
      {"joint",
       {},
       {"origin", "parent", "child", "axis", "limit", "mimic"},
       {"dynamics", "calibration", "safety_controller", "joint_properties"},
       {"name", "type"}},
      {"origin", {}, {}, {}, {"xyz", "rpy", "quat_xyzw"}},
      {"parent", {}, {}, {}, {"link"}},
      {"child", {}, {}, {}, {"link"}},
      {"axis", {}, {}, {}, {"xyz"}},
      {"limit", {}, {}, {}, {"lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"}},
      {"mimic", {}, {}, {}, {"joint", "multiplier", "offset"}},
      {"mass", {}, {}, {}, {"value"}},
      {"inertia", {}, {}, {}, {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}},
  };
  const auto row =
      std::find_if(rows.begin(), rows.end(), [&](const Vocabulary& v) { return v.element == element; });
  return row == rows.end() ? nullptr : &*row;
}

bool contains(const Names& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// A place in the text that moves forward, so that a document needs one pass.
struct Cursor {
  std::size_t byte = 0;
  int line = 1, column = 1;

  void advance(const std::string& text, std::size_t to) {
    if (to < byte) *this = Cursor{};
    for (to = std::min(to, text.size()); byte < to; ++byte) {
      if (text[byte] == '\n') {
        ++line;
        column = 1;
      } else if ((static_cast<unsigned char>(text[byte]) & 0xC0u) != 0x80u) {
        ++column;
      }
    }
  }
};

/// Builds the outline from events of expat. Exceptions must not pass through C code: they are stored until
/// expat returns.
class Outliner {
 public:
  Outliner(const std::string& text, const std::string& file) : text_(text), file_(file) {}
  UrdfElement run();

 private:
  static void on_start(void* self, const XML_Char* name, const XML_Char** attributes) {
    auto& outliner = *static_cast<Outliner*>(self);
    outliner.guarded([&] { outliner.start(name, attributes); });
  }
  static void on_end(void* self, const XML_Char*) {
    auto& outliner = *static_cast<Outliner*>(self);
    outliner.guarded([&] { outliner.end(); });
  }
  static void on_doctype(void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
    auto& outliner = *static_cast<Outliner*>(self);
    outliner.guarded([&] {
      outliner.fail("a document type declaration (DTD) is not allowed", "<!DOCTYPE",
                    "remove it: a URDF needs none");
    });
  }

  template <class Action>
  void guarded(Action&& action) {
    if (thrown_) return;
    try {
      action();
    } catch (...) {
      thrown_ = std::current_exception();
      XML_StopParser(parser_.get(), XML_FALSE);
    }
  }

  void start(const XML_Char* name, const XML_Char** attributes);
  void end();
  void read_attributes(UrdfElement& element, const XML_Char** attributes);
  [[noreturn]] void malformed();
  [[noreturn]] void fail(std::string rule, std::string found, std::string remedy) {
    cursor_.advance(text_,
                    static_cast<std::size_t>(std::max<XML_Index>(0, XML_GetCurrentByteIndex(parser_.get()))));
    throw Error(Fault{
        {file_, cursor_.line, cursor_.column}, "", std::move(rule), std::move(found), std::move(remedy)});
  }

  const std::string& text_;
  const std::string& file_;
  // "UTF-8" overrides the XML declaration: check_text has verified the encoding.
  std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser_{XML_ParserCreate("UTF-8"),
                                                                       &XML_ParserFree};
  Cursor cursor_;
  std::exception_ptr thrown_;
  std::vector<std::pair<std::string, int>> open_;  ///< every open element and its line
  std::vector<UrdfElement> kept_;                  ///< open elements that are read, outermost first
  std::optional<UrdfElement> root_;
  std::size_t nodes_ = 0;
};

UrdfElement Outliner::run() {
  if (!parser_) throw std::bad_alloc();
  XML_SetUserData(parser_.get(), this);
  XML_SetElementHandler(parser_.get(), &on_start, &on_end);
  XML_SetStartDoctypeDeclHandler(parser_.get(), &on_doctype);
  const auto status = XML_Parse(parser_.get(), text_.data(), static_cast<int>(text_.size()), 1);
  if (thrown_) std::rethrow_exception(thrown_);
  if (status != XML_STATUS_OK || !root_) malformed();
  return std::move(*root_);
}

void Outliner::start(const XML_Char* name, const XML_Char** attributes) {
  const std::string_view tag = name;
  if (open_.size() >= most_depth) fail("elements are nested more than 256 deep", "", "");
  if (XML_GetSpecifiedAttributeCount(parser_.get()) > 2 * most_attributes)
    fail("an element has more than 1000 attributes", "<" + std::string(tag) + ">", "");
  if (tag.starts_with("xacro:"))
    fail("this is a xacro template, not a URDF", "<" + std::string(tag) + ">",
         "expand it with xacro first: xacro FILE.xacro > FILE.urdf");
  if (open_.empty() && tag != "robot") {
    const std::string kind = tag == "sdf"      ? "this is an SDF file, not a URDF"
                             : tag == "mujoco" ? "this is a MuJoCo (MJCF) file, not a URDF"
                                               : "the root element of a URDF is <robot>";
    fail(kind, "<" + std::string(tag) + ">",
         tag == "sdf" || tag == "mujoco" ? "convert it to URDF first" : "");
  }
  const Vocabulary* parent = kept_.empty() ? nullptr : vocabulary(kept_.back().name);
  const bool inside_kept = kept_.size() == open_.size();
  cursor_.advance(text_, static_cast<std::size_t>(XML_GetCurrentByteIndex(parser_.get())));
  open_.emplace_back(tag, cursor_.line);
  if (!inside_kept) return;
  UrdfElement element{std::string(tag), cursor_.line, cursor_.column, {}, {}};
  if (++nodes_ > most_nodes) fail("the document is too large for a robot", "over a million elements", "");
  if (!parent || contains(parent->many, tag) || contains(parent->once, tag)) {
    read_attributes(element, attributes);
    kept_.push_back(std::move(element));
  } else if (!contains(parent->ignored, tag)) {
    kept_.back().children.push_back(std::move(element));  // only the name, for the search for misspellings
  }
}

/// Expat gives the place of an element; those of its attributes are found by scanning the well-formed tag.
void Outliner::read_attributes(UrdfElement& element, const XML_Char** attributes) {
  const std::string_view blank = " \t\r\n";
  Cursor cursor = cursor_;
  std::size_t at = text_.find_first_of(" \t\r\n/>", cursor.byte);
  for (; attributes[0] != nullptr; attributes += 2) {
    if (++nodes_ > most_nodes) fail("the document is too large for a robot", "over a million attributes", "");
    at = text_.find_first_not_of(blank, at);
    cursor.advance(text_, at);
    element.attributes.push_back({attributes[0], attributes[1], cursor.line, cursor.column});
    const std::size_t quote = text_.find_first_of("\"'", at);
    at = text_.find(text_[quote], quote + 1) + 1;
  }
}

void Outliner::end() {
  const bool closes_kept = kept_.size() == open_.size();
  open_.pop_back();
  if (!closes_kept) return;
  UrdfElement element = std::move(kept_.back());
  kept_.pop_back();
  if (kept_.empty())
    root_ = std::move(element);
  else
    kept_.back().children.push_back(std::move(element));
}

void Outliner::malformed() {
  const XML_Error code = XML_GetErrorCode(parser_.get());
  const std::string open = open_.empty() ? ""
                                         : "<" + open_.back().first + "> of line " +
                                               std::to_string(open_.back().second) + " is still open";
  switch (code) {
    case XML_ERROR_NO_ELEMENTS:
      if (open_.empty()) fail("the document is empty: a URDF must have a <robot>", "", "");
      fail("unexpected end of the document", "", open);
    case XML_ERROR_TAG_MISMATCH:
      fail("the closing tag does not match", "", open);
    case XML_ERROR_JUNK_AFTER_DOC_ELEMENT:
      fail("nothing may follow </robot>", "", "a URDF must have <robot> as its only root element");
    case XML_ERROR_MISPLACED_XML_PI:
      fail("<?xml ...?> must be at the start of the file", "", "remove the text before it");
    default:
      fail(std::string("the XML is malformed: ") + XML_ErrorString(code), "", "");
  }
}

/// Reports misspelt and duplicate elements and attributes, which a lenient reader would skip silently.
class VocabularyCheck {
 public:
  explicit VocabularyCheck(FaultList& faults) : faults_(faults) {}

  void visit(const UrdfElement& element, const std::string& owner) {
    const Vocabulary& row = *vocabulary(element.name);
    for (const UrdfAttribute& attribute : element.attributes) check(attribute, element, row, owner);
    std::set<std::string> seen;
    for (const UrdfElement& inner : element.children) {
      const bool single = contains(row.once, inner.name);
      if (single && !seen.insert(inner.name).second)
        faults_.add(inner.line, inner.column, owner, "duplicate <" + inner.name + ">", "",
                    "keep one of them");
      if (!single && !contains(row.many, inner.name))
        unknown(inner, row, owner);
      else
        visit(inner, single ? owner : inner.title());
    }
  }

 private:
  /// The known word that `word` misspells, or "". Foreign words are stored, so that each is compared only
  /// once.
  std::string misspelt(const std::string& word, std::string_view element, const Names& known) {
    if (word.size() > longest_word || word.find(':') != std::string::npos) return {};
    std::string entry = std::string(element) + ' ' + word;
    if (foreign_.size() >= most_foreign || foreign_.contains(entry)) return {};
    std::string near = nearest(word, known);
    if (near.empty()) foreign_.insert(std::move(entry));
    return near;
  }

  void unknown(const UrdfElement& inner, const Vocabulary& row, const std::string& owner) {
    Names known = row.many;
    known.insert(known.end(), row.once.begin(), row.once.end());
    known.insert(known.end(), row.ignored.begin(), row.ignored.end());
    const std::string near = misspelt(inner.name, row.element, known);
    if (near.empty() || contains(row.ignored, near)) return;
    faults_.add(inner.line, inner.column, owner, "unknown element", "<" + inner.name + ">",
                "did you mean <" + near + ">?");
  }

  void check(const UrdfAttribute& attribute, const UrdfElement& element, const Vocabulary& row,
             const std::string& owner) {
    const auto& [name, value, line, column] = attribute;
    if (value.find("${") != std::string::npos || value.find("$(") != std::string::npos)
      faults_.add(line, column, owner, "this is a xacro template, not a URDF", "'" + value + "'",
                  "expand it with xacro first: xacro FILE.xacro > FILE.urdf");
    if (name == "quat_xyzw")
      faults_.add(line, column, owner, "a quaternion in <origin> is not supported", "'quat_xyzw'",
                  "write rpy=\"ROLL PITCH YAW\" in radians");
    if (contains(row.attributes, name)) return;
    const std::string near = misspelt(name, element.name, row.attributes);
    if (near.empty()) return;
    faults_.add(line, column, owner, "unknown attribute of <" + element.name + ">", "'" + name + "'",
                "did you mean '" + near + "'?");
  }

  FaultList& faults_;
  std::set<std::string> foreign_;  ///< "ELEMENT WORD"
};

}  // namespace

const UrdfAttribute* UrdfElement::attribute(std::string_view wanted) const {
  for (const UrdfAttribute& a : attributes)
    if (a.name == wanted) return &a;
  return nullptr;
}

const UrdfElement* UrdfElement::child(std::string_view wanted) const {
  for (const UrdfElement& c : children)
    if (c.name == wanted) return &c;
  return nullptr;
}

std::string UrdfElement::title() const {
  const UrdfAttribute* given = attribute("name");
  return given ? name + " '" + given->value + "'" : name;
}

void FaultList::add(int line, int column, std::string key, std::string rule, std::string found,
                    std::string remedy) {
  faults_.push_back(
      {{file_, line, column}, std::move(key), std::move(rule), std::move(found), std::move(remedy)});
  if (faults_.size() >= most_faults) raise();
}

void FaultList::raise() const {
  if (!faults_.empty()) throw Error(faults_);
}

UrdfElement urdf_outline(const std::string& text, const std::string& file) {
  UrdfElement root = Outliner(text, file).run();
  FaultList faults(file);
  VocabularyCheck(faults).visit(root, root.title());
  faults.raise();
  return root;
}

}  // namespace qerr
