# Makes PAGE, a source file with the report's page, from SOURCE, in BINARY; see CMakeLists.txt. Never
# fails: without npm's packages PAGE is the stub, and the next build tries again.

# What the page is made of.
file(GLOB inputs ${SOURCE}/*.mjs ${SOURCE}/*.json ${SOURCE}/.npmrc ${SOURCE}/page/*)
list(SORT inputs)
set(hashes "")
foreach(input IN LISTS inputs)
  file(SHA256 ${input} hash)
  string(APPEND hashes "${hash} ${input}\n")
endforeach()
set(stamp ${BINARY}/report_page.stamp)
if(EXISTS ${stamp} AND EXISTS ${PAGE})
  file(READ ${stamp} made)
  if(made STREQUAL hashes)
    return()
  endif()
endif()

macro(give_up what log)
  message(WARNING "${what}; the tools are built without the page of --report, the next build tries "
                  "again.\n${log}")
  file(REMOVE ${stamp})
  execute_process(COMMAND ${CMAKE_COMMAND} -E copy_if_different ${SOURCE}/no_page.cc ${PAGE})
  return()
endmacro()

file(GLOB top ${SOURCE}/*.mjs ${SOURCE}/*.json ${SOURCE}/.npmrc)
file(REMOVE_RECURSE ${BINARY}/page)
file(COPY ${top} ${SOURCE}/page DESTINATION ${BINARY})

# Packages: once, as long as they are the same.
file(SHA256 ${SOURCE}/package-lock.json lock)
set(installed ${BINARY}/packages.stamp)
set(have "")
if(EXISTS ${installed})
  file(READ ${installed} have)
endif()
if(NOT have STREQUAL lock OR NOT EXISTS ${BINARY}/node_modules)
  file(REMOVE ${installed})
  # Scripts of packages are not run: none of ours needs one.
  execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --fetch-retries=1 --fetch-retry-mintimeout=1000
                          --fetch-timeout=60000
                          --loglevel=error
                  WORKING_DIRECTORY ${BINARY}
                  RESULT_VARIABLE failed
                  OUTPUT_VARIABLE log
                  ERROR_VARIABLE log)
  if(failed)
    give_up("npm could not install the packages of the report" "${log}")
  endif()
  file(WRITE ${installed} ${lock})
endif()

execute_process(COMMAND ${NODE} build.mjs ${BINARY}/made.cc ${BINARY}/report_page.html
                WORKING_DIRECTORY ${BINARY}
                RESULT_VARIABLE failed
                OUTPUT_VARIABLE log
                ERROR_VARIABLE log)
if(failed)
  give_up("the page of the report could not be bundled" "${log}")
endif()
execute_process(COMMAND ${CMAKE_COMMAND} -E copy_if_different ${BINARY}/made.cc ${PAGE})
file(WRITE ${stamp} "${hashes}")
