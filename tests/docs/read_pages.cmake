# What the filter of the comments has to get right, seen in the pages that come out:
# cmake -DHTML=build/docs/html -DSOURCE=. -DINTERNAL=yaml_reader.h -P read_pages.cmake

cmake_minimum_required(VERSION 3.22)

function(expect_text page text)
  if(NOT EXISTS ${HTML}/${page})
    message(SEND_ERROR "${page}: no such page")
    return()
  endif()
  file(READ ${HTML}/${page} html)
  string(FIND "${html}" "${text}" found)
  if(found LESS 0)
    message(SEND_ERROR "${page}: expected ${text}")
  endif()
endfunction()

# A formula keeps its layout, and its source is said.
expect_text(classdarboux_1_1MembraneEnergy.html
  "<pre class=\"fragment\">U = E h / (2 (1 - nu^2)) (e11^2 + e22^2 + 2 nu e11 e22 + (1 - nu)/2 e12^2) dA   [J] </pre>")
expect_text(classdarboux_1_1MembraneEnergy.html "Tian &amp; Jia (2010), eq. (58), term 1")
# An abbreviation does not end a summary.
expect_text(group__costs.html "eq. (58), term 1, eq. (38) in the linear theory")
# What a comment says in HTML's own characters.
expect_text(structdarboux_1_1SolverOptions.html
  "Converged when |gradient| &lt;= tolerance * (|loads| + |reactions|), Euclidean norms.")
# Comments behind members and enumerators.
expect_text(structdarboux_1_1SolverOptions.html "per load step")
expect_text(structdarboux_1_1FingerSpec.html "Coulomb's coefficient")
expect_text(group__solver.html "p V^1.4 = const")
# Lists, terms, code in comments.
expect_text(structdarboux_1_1Taylor3.html "<li>abs at 0: zero, the mean of both sides;")
expect_text(classdarboux_1_1ShellSurface.html "<li>parametric: the exact sigma")
expect_text(structdarboux_1_1Taylor3.html "const Taylor3 f = sin(u) * pow(v, 3);")
# Doxygen leaves text in quotes alone.
expect_text(classdarboux_1_1Expression.html "\"0 &lt; u &lt; 1\" is a mistake")
expect_text(group__geometry.html "<li>.ply, .obj, .stl, .off: the vertices, see")
# Names are links.
expect_text(group__solver.html "href=\"structdarboux_1_1SolverSummary.html\"")
expect_text(index.html "href=\"group__geometry.html\"")

# Every header that is installed has a page, the others none.
file(GLOB headers RELATIVE ${SOURCE}
     ${SOURCE}/geometry/*.h ${SOURCE}/costs/*.h ${SOURCE}/solver/*.h)
foreach(header ${headers})
  get_filename_component(name ${header} NAME_WE)
  string(REPLACE "_" "__" page ${name})
  if(${name}.h IN_LIST INTERNAL)
    if(EXISTS ${HTML}/${page}_8h.html)
      message(SEND_ERROR "${header} is internal and has a page")
    endif()
  elseif(NOT EXISTS ${HTML}/${page}_8h.html)
    message(SEND_ERROR "${header} has no page")
  endif()
endforeach()

# Nothing is left of comments' own marks, and no command is taken for one.
file(GLOB pages ${HTML}/class*.html ${HTML}/struct*.html ${HTML}/group*.html)
foreach(page ${pages})
  file(READ ${page} html)
  if(html MATCHES "<pre class=\"fragment\">[ \n]*//" OR html MATCHES ">[ ]*///" OR
     html MATCHES "@verbatim|@endverbatim|@file|@layer")
    message(SEND_ERROR "${page}: found '${CMAKE_MATCH_0}'")
  endif()
endforeach()
