# Filter of Doxygen: shows it the plain comments of our headers as documentation.
#
#   // above a declaration   -> /** */      (not in bodies of functions, not in lists of parameters)
#   // behind one            -> ///<
#   // followed by nothing   -> @file       (what a header as a whole is about)
#   `name`                   -> <code>name</code>
#   indented lines           -> @verbatim   (formulas, tables, code), but for lists
#
# What Doxygen would take for a command is escaped: the text means what it says. What is declared in
# folder/NAME.h becomes a member of the module `folder` (mainpage.dox). Numbers of lines stay.
#
#   awk -f comments.awk geometry/strain_point.h

{ line[NR] = $0 }

END {
  count = split(FILENAME, path, "/")
  layer = count > 1 ? path[count - 1] : ""
  depth = 0       # of braces, of which kind[k] is what the k-th is of
  parens = 0      # of ( and [
  statement = ""  # code since the last ; { or }
  FindModule()
  for (i = 1; i <= NR; ++i) {
    if (i in done) continue
    if (IsComment(line[i]) && InScope()) {
      first = i
      while (i < NR && IsComment(line[i + 1])) ++i
      Block(first, i)
    } else {
      Code(i)
    }
  }
  for (i = 1; i <= NR; ++i) print line[i]
}

function IsComment(text) { return text ~ /^[ \t]*\/\// }
function IsEmpty(text) { return text ~ /^[ \t]*$/ }

function Indent(text) {
  match(text, /^[ \t]*/)
  return RLENGTH
}

# Text of a comment line, with what it is indented by.
function TextOf(text) {
  sub(/^[ \t]*\/\/ ?/, "", text)
  return text
}

# Where declarations may stand: in namespaces, classes and lists of enumerators.
function InScope(    k) {
  if (parens > 0) return 0
  for (k = 1; k <= depth; ++k) if (kind[k] == "body") return 0
  return 1
}

# The guard of the header makes room for what is said of the file, and the empty line below
# "namespace darboux {", or below the remarks on the file that follow it, for the module.
function FindModule(    n, k) {
  if (layer == "") return
  for (n = 1; n <= NR && line[n] !~ /^namespace darboux [{]$/; ++n) {
    if (line[n] ~ /^#ifndef [A-Z0-9_]+_H_$/) {
      line[n] = "/** @file"
      line[n + 1] = "*/"
      done[n] = done[n + 1] = 1
      for (k = NR; line[k] !~ /^#endif/; --k) continue
      line[k] = ""
    }
  }
  module = 0
  for (k = n + 1; k <= NR && IsEmpty(line[k]);) {
    module = k++
    while (k <= NR && IsComment(line[k])) ++k
    if (k == module + 1) break
  }
  if (module > 0) {
    line[module] = "/** @layer{" layer "} */"
    done[module] = 1
  }
}

# Comment lines first to last, which stand by themselves.
function Block(first, last,    k, next_line, indent) {
  # Aligned with a comment behind the declaration above: more of it.
  for (; first <= last && trailing > 0 && Indent(line[first]) + 1 == trailing; ++first) {
    line[first] = substr(line[first], 1, trailing - 1) "///<" \
                  Escaped(substr(line[first], trailing + 2))
  }
  trailing = 0
  if (first > last || line[first] ~ /NOLINT|clang-format/) return
  next_line = last < NR ? line[last + 1] : ""
  indent = substr(line[first], 1, Indent(line[first]))
  if (IsEmpty(next_line) || last + 1 in done) {
    if (depth > 1 || last == NR) return  # A remark within a class.
    Convert(first, last, indent)
    line[last] = line[last] " @file"
  } else if (next_line ~ /^[ \t]*([}#]|(public|private|protected):)/) {
    return
  } else {
    Convert(first, last, indent)
  }
  sub(/^[ \t]*/, indent "/** ", line[first])
  line[last] = line[last] " */"
}

function Convert(first, last, indent,    k, text, end, in_list, list_indent, spaces, original, pad) {
  in_list = 0
  for (k = first; k <= last; ++k) {
    text = TextOf(line[k])
    spaces = Indent(text)
    if (text ~ /^ *- /) {
      in_list = 1
      list_indent = spaces
    } else if (IsEmpty(text) || spaces <= list_indent) {
      in_list = 0
    }
    if (in_list || spaces < 2) {
      original = line[k]
      line[k] = indent Escaped(text)
      continue
    }
    # Up to the last indented line; empty ones between belong to it.
    end = k
    while (end < last && (IsEmpty(TextOf(line[end + 1])) || Indent(TextOf(line[end + 1])) > 1)) {
      ++end
    }
    while (IsEmpty(TextOf(line[end]))) --end
    if (k > first && !IsEmpty(TextOf(original)) && IsHanging(TextOf(original), k, end)) {
      if (k - 1 == first) pad = "    "  # of "/** "
      line[k - 1] = indent (k - 1 == first ? "" : pad) "- " Escaped(TextOf(original))
      for (; k <= end; ++k) {
        text = TextOf(line[k])
        line[k] = indent pad "  " Escaped(substr(text, Indent(text) + 1))
      }
    } else if (IsTerms(k, end)) {
      Terms(k, end, indent)
    } else {
      Verbatim(k, end, indent, first)
    }
    k = end
  }
}

# A sentence that begins with "name: " and goes on indented.
function IsHanging(head, first, last,    k) {
  if (head !~ /^[A-Za-z_., ]+: +[a-z]/ || index(head, ":") > 30) return 0
  for (k = first; k <= last; ++k) if (TextOf(line[k]) !~ /^  [^ ]/ || line[k] ~ / = /) return 0
  return 1
}

# "name: a sentence" at the least indentation, and what goes on is indented more.
function IsTerms(first, last,    k, text, base) {
  base = Indent(TextOf(line[first]))
  for (k = first; k <= last; ++k) {
    text = TextOf(line[k])
    if (IsEmpty(text) || Indent(text) < base) return 0
    if (Indent(text) == base &&
        (text !~ /^ *[A-Za-z][A-Za-z0-9_ ,]*: +[a-zA-Z]/ || text ~ / = |[{};]$/)) {
      return 0
    }
  }
  return 1
}

function Terms(first, last, indent,    k, text, base) {
  base = Indent(TextOf(line[first]))
  for (k = first; k <= last; ++k) {
    text = TextOf(line[k])
    line[k] = indent (Indent(text) == base ? "- " : "  ") Escaped(substr(text, Indent(text) + 1))
  }
}

# The commands have to be somewhere without a line of their own.
function Verbatim(first, last, indent, block,    k, text, base) {
  base = 1000
  for (k = first; k <= last; ++k) {
    text = TextOf(line[k])
    if (!IsEmpty(text) && Indent(text) < base) base = Indent(text)
  }
  for (k = first; k <= last; ++k) {
    text = substr(TextOf(line[k]), base + 1)
    gsub(/\*\//, "* /", text)
    line[k] = text
  }
  if (first > block) {
    # Doxygen would put a full stop behind the comma of a summary that ends here.
    if (first - 2 >= block && IsEmpty(line[first - 1])) sub(/,$/, "", line[first - 2])
    line[first - 1] = line[first - 1] " @verbatim"
  } else {
    line[first] = "@verbatim " line[first]
  }
  line[last] = line[last] " @endverbatim"
}

# A line that has code, or nothing.
function Code(number,    text, c, k, quote, column, was_scope, before) {
  text = line[number]
  trailing = 0
  if (text ~ /^[ \t]*#/) return
  quote = ""
  column = 0
  was_scope = InScope()
  for (k = 1; k <= length(text); ++k) {
    c = substr(text, k, 1)
    if (quote != "") {
      if (c == "\\") ++k
      else if (c == quote) quote = ""
      continue
    }
    if (c == "/" && substr(text, k + 1, 1) == "/") {
      column = k
      break
    }
    if (c == "\"" || (c == "'" && substr(text, k - 1, 1) !~ /[0-9]/)) {  # 1'000 has none.
      quote = c
      continue
    }
    if (c == "(" || c == "[") ++parens
    if (c == ")" || c == "]") --parens
    if (c == "{") {
      kind[++depth] = KindOf(statement)
      statement = ""
    } else if (c == "}") {
      --depth
      statement = ""
    } else if (c == ";" && parens == 0) {
      statement = ""
    } else {
      statement = statement c
    }
  }
  statement = statement " "
  if (module > 0 && text ~ /^}  \/\/ namespace darboux$/) {
    line[number] = "/** @} */ " text
    return
  }
  if (column == 0 || !InScope() || !was_scope) return
  before = substr(text, 1, column - 1)
  # Behind an opening or a closing brace alone it is about what is inside.
  if (before ~ /^[ \t]*};?[ \t]*$/ || before ~ /[{][ \t]*$/ || text ~ /NOLINT/) return
  line[number] = before "///<" Escaped(substr(text, column + 2))
  trailing = column
}

function KindOf(before) {
  if (before ~ /(^|[^A-Za-z_])namespace([^A-Za-z_]|$)/) return "namespace"
  if (before ~ /[()=]/) return "body"
  if (before ~ /(^|[^A-Za-z_])(class|struct|union|enum)[^A-Za-z_]/) return "class"
  return "body"
}

# Doxygen leaves text in double quotes alone.
function Escaped(text,    out, c, k, is_code, pairs, quotes, is_quoted) {
  pairs = gsub(/`/, "`", text) % 2 == 0
  quotes = gsub(/"/, "\"", text) % 2 == 0
  is_quoted = 0
  is_code = 0
  out = ""
  for (k = 1; k <= length(text); ++k) {
    c = substr(text, k, 1)
    if (c == "\"" && quotes) is_quoted = !is_quoted
    if (is_quoted && substr(text, k, 2) != "*/") {
      out = out c
    } else if (c == "`" && pairs) {
      out = out (is_code ? "</code>" : "<code>")
      is_code = !is_code
    } else if (c == "#" && substr(text, k + 1, 1) !~ /[A-Za-z_:]/) {
      out = out c
    } else if (index("\\@&<>#%$", c) > 0) {
      out = out "\\" c
    } else if (substr(text, k, 2) == "--") {
      out = out "\\--"
      ++k
    } else if (substr(text, k, 2) == "*/") {
      out = out "* /"
      ++k
    } else {
      out = out c
    }
  }
  # An abbreviation does not end the first sentence, which Doxygen takes for a summary.
  gsub(/(eqs?|Eqs?|[Ss]ec|[Ff]ig|pp?|e\.g|i\.e|cf|vs|St|al|approx|resp)\. /, "&\\ ", out)
  # Nor does an initial.
  while (match(out, /(^|[ (])[A-Z]\. /)) {
    out = substr(out, 1, RSTART + RLENGTH - 2) "\\ " substr(out, RSTART + RLENGTH)
  }
  gsub(/\. \\ /, ".\\ ", out)
  return out
}
