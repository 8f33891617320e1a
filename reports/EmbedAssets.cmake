# Stops the configuration, saying what to do, where a file below POWDERCAL_NODE_MODULES is missing.
function(powdercal_require_node_files)
  foreach(file IN LISTS ARGN)
    if(NOT EXISTS ${POWDERCAL_NODE_MODULES}/${file})
      message(FATAL_ERROR
        "The report's plotting libraries are missing (${POWDERCAL_NODE_MODULES}/${file}). "
        "Run `npm ci` in ${PROJECT_SOURCE_DIR}, or set POWDERCAL_NODE_MODULES to the folder that "
        "holds the packages of package.json.")
    endif()
  endforeach()
endfunction()

# powdercal_collect_licences(OUTPUT package …): their licence texts, one after the other. The texts have
# to go wherever the libraries go, so into every report.
function(powdercal_collect_licences output)
  set(text "")
  foreach(package IN LISTS ARGN)
    file(GLOB files ${POWDERCAL_NODE_MODULES}/${package}/LICENSE*
                    ${POWDERCAL_NODE_MODULES}/${package}/LICENCE*)
    list(GET files 0 file)
    file(READ ${file} licence)
    string(STRIP "${licence}" licence)
    string(APPEND text "${package}\n\n${licence}\n\n----------------------------------------\n\n")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  endforeach()
  file(CONFIGURE OUTPUT ${output} CONTENT "${text}" @ONLY)
endfunction()

# powdercal_embed_assets(VARIABLE file …): generates a C++ file that defines Asset() of
# reports/assets.h for these files, and puts its path into VARIABLE.
function(powdercal_embed_assets variable)
  set(ASSET_BYTES "")
  set(ASSET_TABLE "")
  set(paths "")
  set(index 0)
  foreach(file IN LISTS ARGN)
    get_filename_component(path ${file} ABSOLUTE)
    get_filename_component(name ${file} NAME)
    set(symbol powdercal_asset_${index})
    string(APPEND ASSET_BYTES
      "__asm__(\".pushsection .rodata\\n\"\n"
      "        \".global ${symbol}_begin\\n${symbol}_begin:\\n\"\n"
      "        \".incbin \\\"${path}\\\"\\n\"\n"
      "        \".global ${symbol}_end\\n${symbol}_end:\\n\"\n"
      "        \".popsection\\n\");\n"
      "extern \"C\" const char ${symbol}_begin[];\n"
      "extern \"C\" const char ${symbol}_end[];\n\n")
    string(APPEND ASSET_TABLE
      "  if (name == \"${name}\") return {${symbol}_begin, ${symbol}_end};\n")
    list(APPEND paths ${path})
    math(EXPR index "${index} + 1")
  endforeach()
  set(source ${CMAKE_CURRENT_BINARY_DIR}/assets.cc)
  configure_file(${CMAKE_CURRENT_SOURCE_DIR}/assets.cc.in ${source} @ONLY)
  # The compiler does not report what the assembler read.
  set_source_files_properties(${source} PROPERTIES OBJECT_DEPENDS "${paths}")
  set(${variable} ${source} PARENT_SCOPE)
endfunction()
